"""docs/gallery/: a page for each case, from its header, its options and docs/gallery/cases.csv.

cases.csv has one line a case: case, group, picture and picture2 (names in cases/pictures/), draws (the command that draws the
picture), cpu (CPU time of the run with the default options), error (the most telling accuracy), page (in docs/validation/).
"""
import csv

from tools.base.command import ROOT, BadInput
from tools.docs import options
from tools.docs.headers import blocks, header, prose

GROUPS = {
    "particles": "Resolved particles",
    "spheres": "Spheres in three dimensions",
    "flow": "Flow without particles",
    "turbulence": "Steady turbulent flow",
    "points": "Point particles",
    "contacts": "Contacts alone",
}
INDEX = """# Gallery

Every example case has a page: what it shows, how to run it, what it costs, how accurate it is, and which options it has.
CPU times are those of the default run on one core of an AMD EPYC; they vary by a factor of up to 2.5 between days and
machines. In the commands for pictures RUN is the folder of a run.

*The pages of the gallery are made by `python -m tools.docs` from the headers of the cases.*
"""


def entries():
    """The lines of cases.csv, in its order: a dict of case: dict of column: text. Raises BadInput where a case is missing."""
    with open(ROOT / "docs/gallery/cases.csv", newline="") as file:
        found = {row["case"]: row for row in csv.DictReader(file)}
    on_disk = {path.stem for path in (ROOT / "cases").glob("*.edp")}
    for case in sorted(on_disk ^ set(found)):
        raise BadInput(f"docs/gallery/cases.csv and cases/ differ in '{case}': give each case a line")
    return found


def title(case):
    """The title of a case and what it shows: the two parts of the first line of its header, the second may be empty."""
    first, _, rest = header(f"cases/{case}.edp")[0].strip().partition(": ")
    return first.rstrip("."), rest[:1].upper() + rest[1:]


def page(entry, helps):
    """The page of a case."""
    case = entry["case"]
    path = f"cases/{case}.edp"
    name, shows = title(case)
    text = f"# {name}\n\n" + (f"{prose(shows)}\n\n" if shows else "")
    for picture in (entry["picture"], entry["picture2"]):
        if picture:
            text += f"![{name}](../../cases/pictures/{picture})\n\n"
    if entry["draws"]:
        text += f"{'Drawn' if entry['picture'] else 'A picture is drawn'} by {prose(entry['draws'])}.\n\n"
    facts = [("Case", f"`{path}`"), ("Driver", f"`scripts/{options.driver_of(path)}`"), ("CPU time", entry["cpu"]),
        ("Error", entry["error"])]
    if entry["page"]:
        facts.append(("Validation", f"[{entry['page'].replace('_', ' ')}](../validation/{entry['page']}.md)"))
    text += "| | |\n| --- | --- |\n" + "".join(f"| {name} | {value} |\n" for name, value in facts if value) + "\n## The scene\n\n"
    for kind, block in blocks(header(path)[1:]):
        text += prose(block) + "\n\n" if kind == "prose" else f"```text\n{block}\n```\n\n"
    own = [option for option in helps[path] if option.name in options.own_options(path)]
    if own:
        text += "## Options of the case\n\n" + options.table(own) + "\n"
    return text + "The options of its driver stand in [the reference](../reference/options.md).\n"


def index(found):
    """The page with the thumbnails and the list of all pages."""
    text = INDEX
    for group, name in GROUPS.items():
        text += f"\n## {name}\n\n| picture | case |\n| --- | --- |\n"
        for case, entry in found.items():
            if entry["group"] == group:
                picture = (f"[![{case}](../../cases/pictures/{entry['picture']}){{.thumbnail}}]({case}.md)" if entry["picture"]
                    else "")
                name, shows = title(case)
                text += f"| {picture} | [`{case}`]({case}.md). {prose(shows or name)} |\n"
    listed = "\n".join(found)
    return text + f"\n```{{toctree}}\n:hidden:\n\n{listed}\n```\n"


def pages(helps):
    """The pages of the gallery, from all_helps(): a dict of path: text."""
    found = entries()
    made = {f"docs/gallery/{case}.md": page(entry, helps) for case, entry in found.items()}
    return made | {"docs/gallery/index.md": index(found)}
