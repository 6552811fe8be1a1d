"""The pages: links lead somewhere, what they name is there, what is made from the code is up to date, what a reader types runs."""
import re

import pytest

from tests.conftest import ROOT, run_tool
from tools.docs import headers, options, tables
from tools.docs.__main__ import made_pages, stale_pages

PAGES = sorted(str(path.relative_to(ROOT)) for path in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
# by the reader, or by a run
WRITTEN = ("case.edp", "my_case.edp", "junction.edp", "vortices.edp", "vortices_mesh.edp", "grains.edp", "cases/my_case.edp",
    "test_my_case.py")


def read(page):
    return (ROOT / page).read_text()


def without_code(text):
    """A page without blocks and words of code."""
    return re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.S)


def anchors(page):
    """What a link into the page may name: its headings as GitHub and MyST write them, and its own marks (name)=."""
    text = read(page)
    bare = re.sub(r"```.*?```", "", text, flags=re.S)
    heads = [re.sub(r"[^\w -]", "", line.lower()).strip().replace(" ", "-") for line in re.findall(r"^#+ (.*)$", bare, flags=re.M)]
    return {*heads, *re.findall(r"^\(([\w-]+)\)=$", text, flags=re.M)}


def broken_links(page, text):
    """The links of a text, as if it stood in that page, that lead nowhere within the project."""
    found = []
    for link in re.findall(r"\]\(([^)\s]+)\)", without_code(text).replace("[]", "[x]")):
        path, _, mark = link.partition("#")
        target = ((ROOT / page).parent / path).resolve() if path else ROOT / page
        if "://" not in link and (not target.exists() or mark and mark not in anchors(target.relative_to(ROOT))):
            found.append(link)
    return found


@pytest.mark.parametrize("page", PAGES)
def test_the_links_of_a_page_lead_somewhere(page):
    assert broken_links(page, read(page)) == []


def test_a_broken_link_is_found():
    assert broken_links("docs/index.md", "[a](nowhere.md) [b](cost.md#no-such-heading) [c](cost.md#cost-against-size) "
        "![d](../cases/pictures/no.png)") == \
        ["nowhere.md", "cost.md#no-such-heading", "../cases/pictures/no.png"]


@pytest.mark.parametrize("page", PAGES)
def test_a_page_names_what_is_there(page):
    text = read(page)
    for module in re.findall(r"python -m (tools(?:\.\w+)+)", text):
        assert (ROOT / (module.replace(".", "/") + ".py")).is_file() or (ROOT / module.replace(".",
            "/")).is_dir() or module.endswith(".NAME"), module
    there = [str(path.relative_to(ROOT)) for folder in ("cases", "lib", "scripts", "tests", "tools")
        for path in (ROOT / folder).rglob("*")]
    for name in re.findall(r"`([\w/]+\.(?:idp|edp|py))`", text):
        assert any(path == name or path.endswith("/" + name) for path in there) or name in WRITTEN, name
    for name in re.findall(r"(?:FreeFem\+\+ -nw|^include) \"?((?:cases|scripts|lib)/[\w/.]+)", text, flags=re.M):
        assert (ROOT / name).is_file() or name in WRITTEN, name
    for target in re.findall(r"`make (\w+)", text):
        assert re.search(rf"^{target}:", read("Makefile"), flags=re.M), target
    tests = "".join(path.read_text() for path in (ROOT / "tests").rglob("*.py")) if "`test_" in text else ""
    for name in re.findall(r"`(test_\w+)`", text):
        assert f"def {name}(" in tests, name


def test_every_lesson_names_the_test_that_guards_it():
    lessons = re.findall(r"^- .*", read("docs/developers/lessons.md"), flags=re.M)
    unguarded = [lesson for lesson in lessons if "`test_" not in lesson and "No test can guard it" not in lesson]
    assert len(lessons) > 40 and unguarded == []


def test_every_page_is_reached_from_the_first_one():
    reached, open_ends = set(), ["docs/index.md"]
    while open_ends:
        page = open_ends.pop()
        reached.add(page)
        for block in re.findall(r"^```\{toctree\}\n(.*?)^```", read(page), flags=re.M | re.S):
            names = [line for line in block.splitlines() if line and not line.startswith(":")]
            folder = (ROOT / page).parent
            open_ends += [str((folder / f"{name}.md").relative_to(ROOT)) for name in names]
    assert reached == {page for page in PAGES if page.startswith("docs/")}


def test_the_equations_that_the_code_cites_have_one_number_each():
    tags = [tag for page in PAGES if page.startswith("docs/theory/") for tag in re.findall(r"\\tag\{(\d+)\}", read(page))]
    assert sorted(tags, key=int) == [str(number) for number in range(1, len(tags) + 1)] and len(tags) == 8


@pytest.mark.parametrize("page", [page for page in PAGES if "$$" in read(page)])
def test_a_formula_of_several_lines_has_no_number_of_its_own(page):
    """Sphinx puts what has a line break or a column between two dollars into a `split`, where MathJax refuses a tag: such a formula
    is an `equation`."""
    for formula in re.findall(r"\$\$(.*?)\$\$", read(page), flags=re.S):
        assert not ("\\tag" in formula and re.search(r"\\\\|&", formula)), formula


def test_first_pages_are_short():
    readme, changes = read("README.md"), read("CHANGELOG.md")
    assert len(readme.splitlines()) <= 120 and len(readme.split()) <= 900
    assert len(changes.splitlines()) <= 60


def test_the_version_is_one():
    version = re.search(r'^version = "(.+)"$', read("pyproject.toml"), flags=re.M).group(1)
    assert f"version: {version}\n" in read("CITATION.cff")
    assert re.search(r"^## (.+)$", read("CHANGELOG.md"), flags=re.M).group(1) == version
    assert f"version {version}" in read("docs/cite.md")
    assert f'string outVersion = "{version}"' in read("lib/core/run_json.idp")


@pytest.fixture(scope="module")
def pages():
    return made_pages()


def test_pages_made_from_the_code_are_up_to_date(pages):
    assert stale_pages(pages) == [], "run python -m tools.docs"
    kept = {str(path.relative_to(ROOT)) for path in (ROOT / "docs/gallery").glob("*.md")}
    assert kept == {name for name in pages if name.startswith("docs/gallery/")}, "a page of a case that there is no longer"


def test_a_changed_page_is_stale(pages):
    name = "docs/reference/options.md"
    assert stale_pages({name: pages[name].replace("`-cfl`", "`-courant`")}) == [name]
    assert stale_pages({"docs/reference/no_such_page.md": ""}) == ["docs/reference/no_such_page.md"]


def test_every_table_is_in_the_reference():
    """A table that a file begins by outHeader(...) has a section; one with other columns makes the page stale."""
    written = {(str(path.relative_to(ROOT)), name) for folder in ("lib", "scripts") for path in (ROOT / folder).rglob("*.[ie]dp")
               for name in re.findall(r'outHeader\("([\w.]+)",\s*"', re.sub(r"^//.*$", "", path.read_text(), flags=re.M))}
    assert written == {(table.writer, table.name) for table in tables.TABLES if table.writer}


def test_every_driver_is_in_the_reference():
    assert set(options.DRIVERS) == {path.name for path in (ROOT / "scripts").glob("*.edp")}


def test_every_tool_is_in_the_reference():
    tools = {path.stem for path in (ROOT / "tools").glob("*.py") if "__main__" in path.read_text()}
    tools |= {path.parent.name for path in (ROOT / "tools").glob("*/__main__.py")}
    named = set(re.findall(r"python -m tools\.(\w+)", read("docs/reference/tools.md")))
    assert len(tools) > 25 and tools - named == set()


def test_a_line_of_help_is_read():
    text = "  -dt 0.001 s                       time step\n  -out                              folder (default: x)\n  -mu 0.1 g/(cm s)                  viscosity\n  -help                             this list\n"
    text += "  -start at once        inflow (at once|sine)\n"
    assert [(o.name, o.default, o.unit, o.about) for o in options.read_help(text)] == \
        [("-dt", "0.001", "s", "time step"), ("-out", "", "", "folder (default: x)"), ("-mu", "0.1", "g/(cm s)", "viscosity"),
            ("-start", "at once", "", "inflow (at once|sine)")]


def test_commands_in_a_header_are_code():
    assert headers.prose("with -model k-epsilon (python -m tools.peers.with_openfoam step), -retau 500 to 10000, --size 0.1 and -forces") == \
        "with `-model k-epsilon` (`python -m tools.peers.with_openfoam step`), `-retau 500` to 10000, `--size 0.1` and `-forces`"
    assert headers.prose("python -m tools.plot RUN --plane y=0.5 with -contact-tol 3e-4 and -contact-solver accelerated") == \
        "`python -m tools.plot RUN --plane y=0.5` with `-contact-tol 3e-4` and `-contact-solver accelerated`"


def saved(page):
    """The files that a page asks its reader to save: a dict of name: text."""
    return dict(re.findall(r"[Ss]ave (?:these lines|this) as `([\w.]+)`[^`]*```cpp\n(.*?)```", read(page), flags=re.S))


def test_the_case_of_the_readme_is_that_of_the_tutorial():
    assert saved("README.md") == saved("docs/tutorials/first_case.md") and len(saved("README.md")) == 1


@pytest.mark.parametrize("page, mesh, words, table", [
    ("docs/tutorials/first_case.md", None, ["-tend", 0.01, "-fields", 0.01], "particles.csv"),
    ("docs/tutorials/own_domain.md", ["own", "--from", "junction.geo", "--out", "junction.mesh"], ["-tend", 0.1, "-every", 0.05],
        "fluxes.csv"),
    ("docs/tutorials/own_flow.md", ["box", "--width", 0.3, "--height", 0.2, "--size", 0.005, "--out", "tank.mesh"], ["-tend", 0.1],
        "particles.csv"),
    ("docs/tutorials/foreign_flow.md", None, ["-tend", 0.1], "particles.csv"),
])
def test_what_a_tutorial_asks_its_reader_to_type_runs(page, mesh, words, table, freefem, tmp_path):
    for name, text in saved(page).items():
        (tmp_path / name).write_text(text)
    if mesh:
        own = [tmp_path / word if str(word).endswith((".geo", ".mesh")) else word for word in mesh]
        assert f"python -m tools.mesh {' '.join(map(str, mesh))}" in read(page)
        assert run_tool("mesh", *own).returncode == 0
    scripts = sorted(tmp_path.glob("*.edp"))
    assert scripts
    for script in scripts:
        found = re.search(r'"-mesh", "(\w+\.mesh)"', script.read_text())
        where = ["-mesh", tmp_path / found.group(1)] if found else []
        freefem(script, *words, *where, "-out", tmp_path / script.stem)
        assert len((tmp_path / script.stem / table).read_text().splitlines()) > 2
