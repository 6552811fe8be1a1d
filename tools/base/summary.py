"""What a run folder holds, in lines.

    python -m tools.run_folder RUN

Prints how the run was made and how it ended, its tables with their columns and numbers of rows, the numbers of a steady flow, and
the times of its fields.
"""
from tools.base.command import BadInput, Parser
from tools.base.run_folder import RunFolder


def lines_of(run):
    """The lines on a RunFolder."""
    info = run.info
    yield f"case: {run.case}" + (f" ({info['about']})" if info.get("about") else "")
    yield f"status: {run.status or 'not said'}" + (f", {info['wall_s']:g} s" if isinstance(info.get("wall_s"), (int, float)) else "")
    if isinstance(info.get("command"), list):
        yield "command: " + " ".join(map(str, info["command"]))
    if info.get("commit"):
        yield f"commit: {info['commit']}"
    yield "units: " + ", ".join(f"{kind} {name}" for kind, name in run.units.items())
    for path in sorted(run.folder.glob("*.csv")):
        try:
            if path.name == "results.csv":
                yield "results.csv: " + ", ".join(f"{name} {value:.6g} {run.result_units.get(name, '')}".strip()
                    for name, value in run.results.items())
                continue
            table = run.table(path.stem)
            rows = len(next(iter(table.values())))
            yield f"{path.name}: {rows} {'row' if rows == 1 else 'rows'} of {', '.join(table)}"
        except BadInput:  # words in it, or cut off
            yield f"{path.name}: not a table of whole rows of numbers"
    if run.has("particles"):
        yield f"particles: {len(run.tracks)}" + (f", {len(run.held)} of them held" if run.held else "")
    if run.fields:
        first, last = run.fields[0][0], run.fields[-1][0]
        yield f"fields: {len(run.fields)}, t = {first:g} to {last:g} {run.units['time']}"


def main():
    """Prints the lines; 0."""
    parser = Parser(prog="python -m tools.run_folder", description=__doc__)
    parser.add_argument("run", metavar="RUN", help="the folder of a run")
    for line in lines_of(RunFolder(parser.parse_args().run)):
        print(line)
    return 0
