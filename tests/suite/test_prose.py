"""The prose of the pages: numbers stand in tables, sentences explain them."""
import re

import pytest

from tests.conftest import ROOT

MOST = 6  # numbers in a hundred words of a page
FREE = 3  # numbers that a short page may have in any case
WORDY = 20  # a cell of a table with more words than this is prose
MADE = ("docs/gallery/", "docs/reference/options.md", "docs/reference/tables.md")  # from the code
PAGES = sorted(name for name in (str(path.relative_to(ROOT)) for path in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
    if not name.startswith(MADE))


def prose(page):
    """A page without headings, code, formulas, pictures, targets of links, citations, and the short cells of its tables."""
    text = re.sub(r"^\s*(```|:::).*?^\s*\1.*?$", "", page, flags=re.M | re.S)
    text = re.sub(r"\$\$.*?\$\$|\$[^$]*\$|`[^`]*`", "X", text, flags=re.S)
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)|(?<=\])\([^)]*\)|\([^()]*\b(?:19|20)\d\d\)", "", text)
    kept = []
    for line in text.splitlines():
        if line.lstrip().startswith("|"):
            kept += [cell for cell in line.split("|") if len(cell.split()) > WORDY]
        elif not line.startswith(("#", "    ")):
            kept.append(line)
    return "\n".join(kept)


def density(page):
    """Numbers and words of its prose. Parts of names (2D-2, P1) are no numbers."""
    text = prose(page)
    return len(re.findall(r"(?<![\w.-])[-+±]?\d[\d,.]*(?:e[-+]?\d+)?(?!\w)", text)), len(text.split())


def too_dense(page):
    numbers, words = density(page)
    return numbers > max(FREE, MOST * words / 100)


@pytest.mark.parametrize("page", PAGES)
def test_the_prose_of_a_page_is_not_dense_with_numbers(page):
    text = (ROOT / page).read_text()
    assert not too_dense(text), "{} numbers in {} words: move some into a table".format(*density(text))


def test_numbers_are_counted():
    page = ("# Heading 1\n\nIn 2D-2 the P1 error is 1.5 % with 4 elements\n(Erturk, Comput. Fluids 37, 2008), `-dt 0.1`, $x = 3$.\n\n"
        "| 1 | 2 |\n| --- | --- |\n| 3 | a cell of many words, which tells a whole story with 1e-3 and with -7, of this and of that kind, is prose |\n\n"
        "```text\n5 6 7\n```\n![picture 8](9.png) [link](10.md)\n\n    FreeFem++ 11\n")
    assert density(page) == (4, 38)


def test_a_dense_page_is_found():
    assert too_dense("With 4, 6, 8 elements it errs by 0.3 (without: 0.7) and 0.02 %.")
    assert not too_dense("With 4 elements it errs by 2 %.")
