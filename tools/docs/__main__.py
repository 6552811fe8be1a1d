"""Writes the pages of docs/ that are made from the code.

docs/reference/options.md from what the drivers print with -help, docs/reference/tables.md from the headers of the
files that write the tables, docs/gallery/ from the headers of the cases and docs/gallery/cases.csv,
docs/guide/python.ipynb from docs/guide/python.md.
The pages are kept in the repository; a test fails when they are stale. make docs builds all pages.
"""
from tools.base.command import ROOT, Parser, guarded
from tools.docs import gallery, notebook, options, tables


def made_pages():
    """The pages made from the code as they should be: a dict of path from the root: text."""
    helps = options.all_helps()
    return options.pages(helps) | tables.pages() | gallery.pages(helps) | notebook.pages()


def stale_pages(pages):
    """The paths of those pages that are missing or differ from what is on disk."""
    return [name for name, text in pages.items() if not (ROOT / name).is_file() or (ROOT / name).read_text() != text]


def main(argv=None):
    """Writes the stale pages, or with --check only names them (status 1)."""
    parser = Parser(prog="python -m tools.docs", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; status 1 when a page is stale")
    words = parser.parse_args(argv)
    pages = made_pages()
    stale = stale_pages(pages)
    for name in stale:
        print(("stale: " if words.check else "written: ") + name)
        if not words.check:
            (ROOT / name).parent.mkdir(parents=True, exist_ok=True)
            (ROOT / name).write_text(pages[name])
    return 1 if words.check and stale else 0


if __name__ == "__main__":
    guarded(main)
