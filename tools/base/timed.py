"""What a time step costs: of carried spheres, and of a scene that prints it, in a tree of sources of its own.

A tree holds copies of lib/, scripts/ and of the case, with a clock in its macro caseStep(), and
where asked without the statements of a feature: the program that never had it. Each statement
`if (CONDITION) ...` whose condition needs the feature is cut out, its else branch stays.
"""
import re
import shutil
from pathlib import Path

from tools.base.command import ROOT, BadInput
from tools.base.run_folder import RunFolder
from tools.base.runner import finished, run_case

CLOCK = """int benchCalls = 0;
real benchBefore = 0;
real[int] benchSteps(BENCH_STEPS);
func int benchTick() {
    real now = clock();
    if (benchCalls > 0 && benchCalls <= BENCH_STEPS) benchSteps[benchCalls - 1] = now - benchBefore;
    benchCalls++;
    if (benchCalls == BENCH_STEPS + 1) {
        real[int] kept = benchSteps(BENCH_WARM:BENCH_STEPS - 1);
        kept.sort;
        cout.precision(12);
        cout << "bench median " << kept[(BENCH_STEPS - BENCH_WARM)/2] << " mean " << kept.sum/kept.n << endl;
    }
    benchBefore = clock();
    return benchCalls;
}
macro caseStep() benchTick(); // EOM
"""


def closing(text, start, opens, closes):
    """The place behind the bracket that ends the one which opens at `start`."""
    depth = 0
    for k in range(start, len(text)):
        depth += (text[k] == opens) - (text[k] == closes)
        if depth == 0:
            return k + 1
    raise BadInput(f"a {opens} is not closed")


def statement_end(text, start):
    """Where the statement that begins at `start` ends: behind its semicolon or closing brace."""
    at = start + len(text[start:]) - len(text[start:].lstrip())
    if text[at] == "{":
        return closing(text, at, "{", "}")
    guard = re.compile(r"(if|for|while)\s*\(").match(text, at)
    if guard:
        end = statement_end(text, closing(text, guard.end() - 1, "(", ")"))
        other = re.compile(r"\s*else\b").match(text, end)
        return statement_end(text, other.end()) if other and guard.group(1) == "if" else end
    return text.index(";", at) + 1


def without_guarded(text, names):
    """(text without the `if` statements that need one of the names, how many were cut). A condition needs
    a name that stands in it, or in each of its parts between ||; `!name` and `name == 0` need none."""
    count, at = 0, 0
    word = re.compile(r"(?<!!)\b(" + "|".join(names) + r")\b(?!\s*==\s*0\b)")
    while True:
        match = re.compile(r"\bif\s*\(").search(text, at)
        if not match:
            return text, count
        end = closing(text, match.end() - 1, "(", ")")
        condition = text[match.end():end - 1]
        if not word.search(condition) or "||" in condition and not all(word.search(part)
            for part in condition.split("||")) or condition.startswith("!"):
            at = match.end()
            continue
        after = statement_end(text, end)
        other = re.compile(r"\s*else\b").match(text, after)
        # 1; is FreeFEM's empty statement
        text = text[:match.start()] + (text[other.end():].lstrip() if other else "1;" + text[after:])
        count, at = count + 1, match.start()


def without_calls(text, names):
    """(text without the statements NAME(...); of the names, how many were cut)."""
    return re.subn(r"(^|[;{}])(\s*)(?:" + "|".join(names) + r")\([^;{}]*\);", r"\1\2", text, flags=re.M)


def tree(folder, script, steps, warm, guards=(), calls=(), files=()):
    """Make the tree for a script with `steps` timed steps of which the first `warm` do not count;
    guards and calls are cut out of the files named. Returns the folder."""
    folder = Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    for name in ("lib", "scripts"):
        shutil.copytree(ROOT / name, folder / name)
    (folder / script).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(ROOT / "freefem++.pref", folder)
    (folder / "meshes").symlink_to(ROOT / "meshes")
    text = (ROOT / script).read_text()
    driver = re.search(r'^include "scripts/\w+\.edp"', text, flags=re.M)
    if not driver or "caseStep" in text:
        raise BadInput(f"{script} cannot take a clock: it includes no driver, or has its own caseStep")
    clock = CLOCK.replace("BENCH_STEPS", str(steps)).replace("BENCH_WARM", str(warm))
    (folder / script).write_text(text[:driver.start()] + clock + text[driver.start():])
    cut = 0
    for name in files:
        text = (folder / name).read_text()
        for names, take in ((guards, without_guarded), (calls, without_calls)):
            if names:
                text, count = take(text, names)
                cut += count
        (folder / name).write_text(text)
    if (guards or calls) and not cut:
        raise BadInput(f"nothing of {', '.join([*guards, *calls])} stands in {', '.join(files)} any more")
    return folder


def carried_step(number, steps, history, out):
    """(seconds of CPU a step in the flow, in the forces, peak MiB) of `number` spheres carried one way with every force but
    history (Brown-Lawler drag, weight less buoyancy, added mass, fluid acceleration, lift, Magnus, fluctuations), or with it
    too, no contacts. The first steps of a run are its most expensive: the figure is over all of them."""
    folder = out / "runs" / f"{number}_{history}"
    done = finished(run_case("tests/transport/scripts/bench.edp", {"-number": number, "-tend": 0.001 * steps, "-history": history},
        out=folder))
    table = RunFolder(folder).table("steps")
    return table["time_flow"][-1] / steps, table["time_forces"][-1] / steps, done.memory_mb


def step_time(folder, script, options, out, limit=None):
    """(median CPU seconds of a step, peak MiB) of a run in a tree."""
    done = finished(run_case(script, options, out=out, limit=limit, cwd=folder))
    found = re.search(r"^bench median (\S+) mean (\S+)$", done.log, flags=re.M)
    if not found:
        raise BadInput(f"{script} ended before its last timed step")
    shutil.rmtree(out, ignore_errors=True)
    return float(found.group(1)), done.memory_mb
