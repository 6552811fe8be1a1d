"""A new case like one of the project's: its script, a test of it and a page.

    python -m tools.new my_case --like settling_disk
    python -m tools.new my_case --like settling_disk --folder DIR

Without --folder the case becomes one of the project: cases/my_case.edp, a test in the room of its driver in tests/, a line in
tests/cases.py and in docs/gallery/cases.csv, and its page in docs/gallery/. With --folder the three files lie in that folder,
which is made where it is not there: my_case.edp, test_my_case.py, my_case.md. There

    python -m tools.run my_case.edp          runs the case, into results/ beside it
    python -m pytest test_my_case.py         runs a few steps of it and judges what they leave

The script is that of the other case under its own name; what it shows, its parameters and its particles are yours to change.
"""
import csv
import io
import itertools
import keyword
import re
from pathlib import Path

from tools.base.command import ROOT, BadInput, Parser, guarded
from tools.compile_errors.project import nearest
from tools.docs import gallery, options
from tools.docs.headers import blocks, prose

LIST, GALLERY = "tests/cases.py", "docs/gallery/cases.csv"
ROOMS = {"resolved.edp": "bodies", "spheres.edp": "spheres", "flow.edp": "flow", "steady.edp": "steady", "steady_laminar.edp": "steady",
    "transport.edp": "transport", "contacts.edp": "contact", "contact_spheres.edp": "spheres"}
DRAWN = {"resolved.edp": "plot", "spheres.edp": "plot", "flow.edp": "plot", "steady.edp": "plot_steady", "steady_laminar.edp": "plot_steady",
    "transport.edp": "plot_transport", "contacts.edp": "plot_contacts", "contact_spheres.edp": "plot_contacts"}

PICTURE = {"plot": "fields", "plot_steady": "streamlines", "plot_transport": "transport", "plot_contacts": "frames"}

# What a test judges of a run of a few steps: {tables} stands for what the driver writes.
JUDGED = '''    assert run.status == "finished" and run.case == "{name}"
    for table in {tables}:
        rows = run.table(table, finite=True)  # a nan or an infinite number is refused
        assert len(rows["{first}"]) > 0, table
'''
INSIDE = '''    low, high = run.mesh.points.min(axis=0), run.mesh.points.max(axis=0)
    for way, axis in enumerate("xy"):
        centres = run.wrapped(run.particles[axis], way)
        assert low[way] <= centres.min() and centres.max() <= high[way], axis
'''
RESULTS = '''    assert run.status == "finished" and run.case == "{name}"
    assert run.results and all(math.isfinite(value) for value in run.results.values())
'''
OF_THE_PROJECT = '''"""{title}: a few steps of cases/{name}.edp, and what they leave."""
{imports}from tools.base.run_folder import RunFolder


def test_a_few_steps_of_{name}(freefem, run_folder):
    freefem("cases/{name}.edp", {words}"-out", run_folder)
    run = RunFolder(run_folder)
{judged}'''
OF_A_FOLDER = '''"""{title}: a few steps of {name}.edp, and what they leave."""
{imports}import subprocess
import sys
from pathlib import Path

PROJECT = Path("{root}")  # of FreeFEM scripts whose driver the case includes
sys.path.insert(0, str(PROJECT))

from tools.base.run_folder import RunFolder  # noqa: E402

CASE = Path(__file__).with_name("{name}.edp")
OPTIONS = [{words}]


def test_a_few_steps_of_{name}(tmp_path):
    done = subprocess.run([sys.executable, PROJECT / "tools/run.py", CASE, *OPTIONS, "-out", tmp_path / "run"],
        capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    run = RunFolder(tmp_path / "run")
{judged}'''


def main(argv=None):
    """Writes the files, all or none of them where one is there already; prints their names."""
    parser = Parser(prog="python -m tools.new", description=__doc__)
    parser.add_argument("name", help="of the new case: letters, digits and _, not a digit first")
    parser.add_argument("--like", metavar="CASE", required=True, help="a case of cases/, without .edp")
    parser.add_argument("--folder", metavar="DIR", help="one's own folder, outside the project")
    words = parser.parse_args(argv)
    require_name(words.name)
    like = found(words.like)
    files, shown = in_folder(words.name, like, folder_of(words.folder)) if words.folder else in_project(words.name, like)
    for path, _ in files:
        if path.exists() and path not in (ROOT / LIST, ROOT / GALLERY, ROOT / "docs/gallery/index.md"):
            raise BadInput(f"{path} is there already: give the case another name")
    for path, text in files:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    if not words.folder:
        shown += written_page(words.name)
    print("\n".join(f"written: {name}" for name in shown))
    return 0


def require_name(name):
    """Raises BadInput unless a case, a test and a folder may have this name."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,59}", name) or keyword.iskeyword(name):
        raise BadInput(f"'{name}' cannot be the name of a case: letters, digits and _, a letter first, at most 60 of them")
    if name in gallery.entries():
        raise BadInput(f"there is a case {name} in cases/ already: give the new one another name")


def found(like):
    """The name of the case of cases/ that is meant. Raises BadInput."""
    known = sorted(gallery.entries())
    name = like.removeprefix("cases/").removesuffix(".edp")
    if name not in known:
        best = nearest(name, known)
        raise BadInput(f"there is no case {like} in cases/" + (f"; is {best} meant?" if best else ""))
    return name


def folder_of(text):
    """The whole path of one's own folder. Raises BadInput where runs could not lie in it."""
    folder = Path(text).resolve()
    if folder.is_relative_to(ROOT):
        raise BadInput(f"--folder {text} lies in the project; leave --folder out for a case of the project, or name a folder "
            f"outside")
    if not re.fullmatch(r"[A-Za-z0-9._/+=,@%-]+", str(folder)):
        raise BadInput(f"--folder '{folder}' holds signs other than letters, figures and . _ - / + = , @ %, which FreeFEM takes "
            f"in no folder of a run")
    if folder.exists() and not folder.is_dir():
        raise BadInput(f"--folder {text} is a file")
    return folder


def words_of(like):
    """The options of a run of a few steps of a case of the list, as text: "-tend", "0.01"."""
    text = (ROOT / LIST).read_text()
    row = re.search(rf'^    "{like}": \[(.*)\],$', text, flags=re.M)
    return row.group(1) if row else ""


def titled(name):
    """A name as the words of a title."""
    return name.replace("_", " ").capitalize()


def adapted(text, name, like, inside):
    """The text of a case under another name; inside: as one of the project, else in one's own folder."""
    first, rest = text.split("\n", 1)
    _, colon, shows = first.partition(": ")
    lines = [f"// {titled(name)}{colon}{shows}" if colon else f"// {titled(name)}."]
    run = f"cases/{name}.edp" if inside else f"{name}.edp"
    for line in rest.split("\n"):
        if line.startswith("//"):
            line = line.replace(f"results/{like}/", f"results/{name}/")
            line = line.replace(f"FreeFem++ -nw cases/{like}.edp", f"{'FreeFem++ -nw' if inside else 'python -m tools.run'} {run}")
        lines.append(line)
    end = next(k for k, line in enumerate(lines) if not line.startswith("//"))
    lines.insert(end, f"// It began as a copy of cases/{like}.edp.")
    if end > 1 and lines[end - 1].startswith("//   "):
        lines.insert(end, "//")
    whole = "\n".join(lines)
    new = re.sub(rf'optCase\("{like}"', f'optCase("{name}"', whole)
    if new == whole:
        raise BadInput(f"cases/{like}.edp does not call itself {like} (optCase): take another case")
    return new


def judged(name, like):
    """The lines of a test that judge a run, and the imports they need."""
    driver = options.driver_of(f"cases/{like}.edp")
    if driver.startswith("steady"):
        return RESULTS.format(name=name), "import math\n\n"
    tables = {"flow.edp": '("fluid",)', "resolved.edp": '("particles", "fluid")',
        "spheres.edp": '("particles", "fluid")', "transport.edp": '("particles", "steps")',
        "contacts.edp": '("particles", "motion")', "contact_spheres.edp": '("particles", "motion")'}[driver]
    return JUDGED.format(name=name, tables=tables, first="t") + (INSIDE if driver == "resolved.edp" else ""), ""


def command_of_picture(like):
    """What draws a picture of a run of such a case."""
    drawn = gallery.entries()[like]["draws"]
    tool = DRAWN[options.driver_of(f"cases/{like}.edp")]
    return drawn if drawn.startswith("python -m tools.plot") else f"python -m tools.{tool} RUN"


def in_folder(name, like, folder):
    """The files of a case in one's own folder, [(path, text)], and their names to print."""
    lines, imports = judged(name, like)
    words = words_of(like)
    case = adapted((ROOT / f"cases/{like}.edp").read_text(), name, like, False)
    test = OF_A_FOLDER.format(title=titled(name), name=name, root=ROOT, words=words, judged=lines, imports=imports.rstrip("\n")
        + ("\n" if imports else ""))
    files = [(folder / f"{name}.edp", case), (folder / f"test_{name}.py", test), (folder / f"{name}.md", page(name, like, case))]
    return files, [str(path) for path, _ in files]


def page(name, like, case):
    """The page of a case in one's own folder, from the header of its text."""
    lines = [line[2:].rstrip() for line in itertools.takewhile(lambda line: line.startswith("//"), case.split("\n"))]
    shows = lines[0].partition(": ")[2]
    text = f"# {titled(name)}\n\n" + (f"{prose(shows[:1].upper() + shows[1:])}\n\n" if shows else "")
    for kind, block in blocks(lines[1:]):
        text += prose(block) + "\n\n" if kind == "prose" else f"```text\n{block}\n```\n\n"
    text += f"## Picture\n\nOf a run in the folder RUN, as `results/{name}/run_001`: {prose(command_of_picture(like))}.\n\n"
    picture = PICTURE.get(command_of_picture(like).split()[2].removeprefix("tools."), "fields")
    text += f"<!-- ![{titled(name)}](results/{name}/run_001/{picture}.png) -->\n\n"
    return text + f"## Test\n\n```text\npython -m pytest test_{name}.py\n```\n"


def in_project(name, like):
    """The files of a case of the project, [(path, text)], and their names to print; the page comes later (written_page)."""
    driver = options.driver_of(f"cases/{like}.edp")
    lines, imports = judged(name, like)
    words = words_of(like)
    listed = (ROOT / LIST).read_text()
    if f'"{name}"' in listed:
        raise BadInput(f"{LIST} names {name} already: give the case another name")
    listed = re.sub(r"(?m)^}$", f'    "{name}": [{words}],\n}}', listed, count=1)
    coarser = re.search(rf'^COARSER = \{{.*?"{like}": (\[.*?\])', listed, flags=re.M)
    if coarser:
        listed = listed.replace("COARSER = {", f'COARSER = {{"{name}": {coarser.group(1)},\n    ', 1)
    row = io.StringIO()
    csv.writer(row, lineterminator="\n").writerow([name, gallery.entries()[like]["group"], "", "", command_of_picture(like), "", "",
        ""])
    test = OF_THE_PROJECT.format(title=titled(name), name=name, judged=lines, imports=imports, words=words and words + ", ")
    files = [(ROOT / f"cases/{name}.edp", adapted((ROOT / f"cases/{like}.edp").read_text(), name, like, True)),
        (ROOT / f"tests/{ROOMS[driver]}/test_{name}.py", test),
        (ROOT / LIST, listed), (ROOT / GALLERY, (ROOT / GALLERY).read_text() + row.getvalue())]
    for path in (ROOT / f"docs/gallery/{name}.md", *(ROOT / "tests").rglob(f"test_{name}.py")):
        if path.exists():
            raise BadInput(f"{path} is there already: give the case another name")
    return files, [str(path.relative_to(ROOT)) for path, _ in files]


def written_page(name):
    """Writes the page of a case of the project and the index of the gallery; returns their names."""
    path = f"cases/{name}.edp"
    entries = gallery.entries()
    pages = {f"docs/gallery/{name}.md": gallery.page(entries[name], {path: options.ask(path)}),
        "docs/gallery/index.md": gallery.index(entries)}
    for file, text in pages.items():
        (ROOT / file).write_text(text, encoding="utf-8")
    return list(pages)


if __name__ == "__main__":
    guarded(main)
