"""Tables of points as other programs write them, as lines that tools.base.tables reads.

Columns are separated by commas, semicolons, tabs or blanks; where not by commas, numbers may have a decimal comma. Lines that begin
with # or % are remarks; the last of them is the header where only numbers follow. Of a table in sections (CFD-Post: [Name], [Data])
the section [Data] counts. A separator at the end of every line makes no column.
"""
import re

from tools.base.command import BadInput
from tools.base.tables import columns, is_number
from tools.base.text_files import text_of

KINDS = ".csv", ".txt", ".tsv"  # endings of their names
REMARKS = "#", "%"
SECTION = re.compile(r"\s*\[[\w ]+\]\s*$")
WIDE = re.compile(r"\s{2,}")


def separator(header):
    """What separates the names: a tab, ; or , or a pattern for blanks (two and more, where names have single ones)."""
    for one in "\t;,":
        if one in header:
            return one
    if len(header.split()) < 2:
        return ","
    return WIDE if WIDE.search(header.strip()) else re.compile(r"\s+")


def cells(line, by):
    """The line with its cells separated by commas."""
    line = line.strip() if not isinstance(by, str) else line.rstrip("\r\n")
    parts = by.split(line) if not isinstance(by, str) else line.split(by)
    return ",".join(parts) + "\n"


def data_section(lines):
    """Of lines in sections those of [Data], else all."""
    marks = [place for place, (_, line) in enumerate(lines) if SECTION.match(line)]
    begin = next((place for place in marks if lines[place][1].strip().lower() == "[data]"), None)
    if begin is None:
        return lines
    return lines[begin + 1:next((place for place in marks if place > begin), len(lines))]


def read(path):
    """The columns of the table, {name: array}; all values are finite. Raises BadInput."""
    lines = list(enumerate(text_of(path, f"the table {path}", "replace").splitlines(), 1))
    lines = data_section([(number, line) for number, line in lines if line.strip()])
    first = next((place for place, (_, line) in enumerate(lines) if not line.lstrip().startswith(REMARKS)), len(lines))
    body = [(number, line) for number, line in lines[first:] if not line.lstrip().startswith(REMARKS)]
    if body and first and all(is_number(word) for word in re.split(r"[\s,;]+", body[0][1].strip(" ,;\t"))):
        body.insert(0, (lines[first - 1][0], lines[first - 1][1].lstrip().lstrip("".join(REMARKS)).strip()))
    if not body:
        return columns(path, body, True)
    by = separator(body[0][1])
    if by == ",":
        rows = [(number, line + "\n") for number, line in body]
    else:
        decimal = any("," in line for _, line in body[1:]) and not any("." in line for _, line in body[1:])
        point = (lambda line: line.replace(",", ".")) if decimal else (lambda line: line)
        if not decimal and any("," in line for _, line in body[1:]):
            raise BadInput(f"{path}: its numbers have commas as well as points")
        rows = [(body[0][0], cells(body[0][1].replace(",", " "), by))]
        rows += [(number, cells(point(line), by)) for number, line in body[1:]]
    ends = [line.rstrip().endswith(",") for _, line in rows]
    if all(ends):
        rows = [(number, line.rstrip()[:-1] + "\n") for number, line in rows]
    return columns(path, rows, True)
