"""docs/reference/options.md: the options of every driver, from what its cases print with -help."""
import os
import re
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from tools.base.command import ROOT, BadInput

DRIVERS = {
    "resolved.edp": "Particles with the flow around each of them",
    "spheres.edp": "Spheres in three dimensions",
    "contact_spheres.edp": "Spheres and contacts alone",
    "flow.edp": "Unsteady flow without particles",
    "steady_laminar.edp": "Steady laminar flow",
    "steady.edp": "Steady flow with a turbulence model",
    "transport.edp": "Point particles in a given flow",
    "contacts.edp": "Contacts alone",
    "project_velocities.edp": "One projection of velocities from a file",
    "project_spheres.edp": "One projection of velocities of spheres from a file",
}
HEAD = """# Options of the drivers

An option is given behind the name of the case: `FreeFem++ -nw cases/template.edp -dt 0.001`. The flag `-help` lists the
options of a case. A misspelt option or a value out of range ends the run with status 3 before anything is computed.

The tables below hold the options that each driver gives to its cases. A case may choose another default for them; where
cases differ, the table says *by case*. The options that belong to one case stand on its page in the
[gallery](../gallery/index.md).

*This page is made by `python -m tools.docs` from the output of `-help`.*
"""


@dataclass
class Option:
    """One line of -help: the name with its minus, default and unit as printed (may be empty), meaning."""
    name: str
    default: str
    unit: str
    about: str


def cell(text):
    """Text for a cell of a Markdown table."""
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*").replace("$", "\\$")


def driver_of(path):
    """The driver that a script includes, its name in scripts/; a driver without cases is its own."""
    found = re.search(r'^include "scripts/([\w.]+)"', (ROOT / path).read_text(), flags=re.M)
    return found.group(1) if found else path.split("/")[-1]


def own_options(path):
    """The names of the options that the script itself declares."""
    return set(re.findall(r'\bopt[A-Z]\w*\("(-[\w-]+)"', re.sub(r"optDefault\([^)]*\)", "", (ROOT / path).read_text())))


def read_help(text):
    """The options in the output of -help, in its order: a list of Option without -help itself."""
    found = []
    for name, middle, about in re.findall(r"^  (-[\w-]+) (.*?) {2,}(\S.*)$", text, flags=re.M):
        default, _, unit = middle.strip().partition(" ")
        choices = re.search(r"\(([^()]*\|[^()]*)\)$", about)
        if choices and middle.strip() in choices.group(1).split("|"):
            default, unit = middle.strip(), ""  # a choice of several words
        if name != "-help":
            found.append(Option(name, default, unit, about))
    return found


def ask(path):
    """The options of a script, by running it with -help. Raises BadInput where it prints none."""
    command = [os.environ.get("FREEFEM", "FreeFem++"), "-nw", path, "-help"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, errors="replace", timeout=120)
    found = read_help(run.stdout)
    if run.returncode != 0 or not found:
        raise BadInput(f"{' '.join(command)} ended with status {run.returncode} and printed no options: {run.stdout[-300:]}")
    return found


def all_helps():
    """The options of every case and of the scripts that need none: a dict of path from the root: list of Option."""
    paths = [f"cases/{path.name}" for path in sorted((ROOT / "cases").glob("*.edp"))]
    paths += ["scripts/project_velocities.edp", "scripts/project_spheres.edp"]
    with ThreadPoolExecutor(2) as pool:
        return dict(zip(paths, pool.map(ask, paths)))


def table(options):
    """A Markdown table of options."""
    rows = ["| option | default | unit | meaning |", "| --- | --- | --- | --- |"]
    for option in options:
        default = option.default if option.default == "*by case*" else f"`{option.default}`" if option.default else ""
        rows.append(f"| `{option.name}` | {default} | {cell(option.unit)} | {cell(option.about)} |")
    return "\n".join(rows) + "\n"


def of_driver(driver, helps):
    """The options that a driver gives to its cases, with *by case* where defaults differ, in the order of -help."""
    found = {}
    for path, options in helps.items():
        if driver_of(path) == driver:
            own = own_options(path) if path.startswith("cases/") else set()
            for option in options:
                # The default of -out names the case.
                about = re.sub(r"results/\w+/run_NNN", "results/CASE/run_NNN", option.about)
                option = Option(option.name, option.default, option.unit, about)
                if option.name not in own:
                    before = found.setdefault(option.name, option)
                    if before.default != option.default:
                        found[option.name] = Option(option.name, "*by case*", option.unit, about)
    return list(found.values())


def pages(helps):
    """The page of the options, from all_helps(): a dict of path: text."""
    text = HEAD
    for driver, title in DRIVERS.items():
        text += f"\n## {title}: `{driver}`\n\n" + table(of_driver(driver, helps))
    return {"docs/reference/options.md": text}
