"""Numbers that stand on several pages: those of an overview are on the page that it names."""
import csv
import re

import pytest

from tests.conftest import ROOT

NUMBER = r"(?<![\w.])\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?(?![\w]|\.\d)"


def numbers(text):
    """The numbers of a text without formulas, names of code and targets of links, as they are written."""
    text = re.sub(r"\$[^$]*\$|`[^`]*`|(?<=\])\([^)]*\)", " ", text)
    return re.findall(NUMBER, text)


def is_there(number, page):
    """Whether a page has this number, a whole one perhaps with more digits, or as a ratio: 10 % for 1.10 or 0.90."""
    value, digits = float(number.replace(",", "")), len(number.partition(".")[2])
    ratios = [f"{abs(100 * (float(other) - 1)):.{digits}f}" for other in page if re.fullmatch(r"[01]\.\d\d+", other)]
    if number in page or number in ratios:
        return True
    return re.fullmatch(r"\d+", number) and any(round(float(other.replace(",", ""))) == value for other in page if "." in other)


def missing(text, page):
    """The numbers of a text that a page, given as its text, does not have."""
    there = numbers(page)
    return [number for number in numbers(text) if not is_there(number, there)]


def overview():
    """(page, cell) for each row of the tables of docs/validation/index.md that names a page: the deviations and that page."""
    found, page = [], None
    for line in (ROOT / "docs/validation/index.md").read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split(" | ")] if line.startswith("| ") else []
        if len(cells) < 3 or cells[0] in ("scene", "---"):
            continue
        link = re.match(r"\[[^\]]*\]\(([\w./]+)(?:#[\w-]+)?\)", cells[0])
        page = f"docs/validation/{link.group(1)}" if link else page
        if link or cells[0].startswith("the same"):
            found.append((page, cells[-1].strip(" |")))
    return found


def first_page():
    """(page, error) for each row of the table of README.md that names a page."""
    rows = re.findall(r"^\| \[[^\]]*\]\((docs/[\w/]+\.md)\)[^|]*\|([^|]*\|[^|]*)\|", (ROOT / "README.md").read_text(), flags=re.M)
    return [(page, cells.split("|")[1]) for page, cells in rows if re.search(r"\d", cells)]


def of_cases():
    """(page, error) for each case of docs/gallery/cases.csv with a page of validation."""
    with open(ROOT / "docs/gallery/cases.csv", newline="") as file:
        return [(f"docs/validation/{row['page']}.md", row["error"]) for row in csv.DictReader(file) if row["page"] and row["error"]]


@pytest.mark.parametrize("page, cell", first_page() + overview() + of_cases())
def test_the_numbers_of_an_overview_are_on_the_page_it_names(page, cell):
    assert missing(cell, (ROOT / page).read_text()) == []


def test_an_overview_has_rows():
    assert len(first_page()) >= 7 and len(overview()) > 35 and len(of_cases()) > 25


def test_a_number_that_the_page_does_not_have_is_found():
    page = "| 4 | 0.31 % |\n| 8 | 1.10 |\nIn $x = 7$ steps of `-dt 9`, 3.14 of 20,000."
    assert missing("0.31, 10, 3 % of 20,000", page) == []
    assert missing("0.32 %, 7, 9, 3.1", page) == ["0.32", "7", "9", "3.1"]
