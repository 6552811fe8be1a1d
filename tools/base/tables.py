"""CSV tables with one header row: read by column name, lines starting with # skipped.

A table is a dict of float arrays, all of one length, in the order of the header.
Errors: BadInput with the file and line of what cannot be read.
"""
import contextlib
import csv
import io
import os
from pathlib import Path

import numpy as np

from tools.base.command import BadInput
from tools.base.text_files import text_of


def read_table(path, finite=False, of_run=False):
    """The columns of a CSV file as {name: array}. A last row cut short (a run killed
    while writing on a full disk) is an error like any other: rows are whole or wrong.
    A last column `name`, of sides that have names of their own, is an array of texts. finite: nan and inf are errors too.
    of_run: a run wrote it, which ends every line; a last line without its end may be cut within a number."""
    lines = list(enumerate(io.StringIO(text_of(path, f"the table {path}"), newline=""), 1))
    if of_run and lines and not lines[-1][1].endswith("\n"):
        raise BadInput(f"{path}, line {lines[-1][0]}: the line has no end; the run was cut off while it wrote it (or writes it "
            f"now): go on with -restart, or take the line out")
    return columns(path, [(number, line) for number, line in lines if line.strip() and not line.lstrip().startswith("#")], finite)


def columns(path, lines, finite=False):
    """The same of numbered lines [(number, line)] without remarks, the first of which is the header."""
    if not lines:
        raise BadInput(f"the table {path} is empty: it needs a header row")
    names = [name.strip() for name in next(csv.reader([lines[0][1]]))]
    if len(set(names)) < len(names) or "" in names:
        raise BadInput(f"{path}, line {lines[0][0]}: the header has an empty or a repeated column name")
    if all(is_number(name) for name in names):
        raise BadInput(f"{path}, line {lines[0][0]}: a header row with column names is needed, not numbers")
    body, texts = lines[1:], {}
    if names[-1] == "name" and len(names) > 1:
        names, cut = names[:-1], [(number, line.rstrip("\r\n").rpartition(",")) for number, line in body]
        body, texts = [(number, part[0]) for number, part in cut], {"name": np.array([part[2] for _, part in cut], dtype=str)}
    if not body:
        return {name: np.empty(0) for name in names} | texts
    try:
        values = np.loadtxt([line for _, line in body], delimiter=",", comments=None, ndmin=2)
        if values.shape[1] == len(names):
            for row, column in np.argwhere(~np.isfinite(values))[:1] if finite else ():
                raise BadInput(f"{path}, line {body[row][0]}: {names[column]} is {values[row, column]}, not a finite number")
            return {name: values[:, k].copy() for k, name in enumerate(names)} | texts
    except ValueError:
        pass
    raise BadInput(first_fault(path, body, names))


def is_number(text):
    """True if float() takes the text."""
    try:
        float(text)
        return True
    except ValueError:
        return False


def first_fault(path, body, names):
    """One line on the first row that does not fit the header."""
    for number, line in body:
        cells = next(csv.reader([line]))
        if len(names) == 1 and len(names[0].split()) + names[0].count(";") > 1:
            return f"{path}: the names of the columns, '{names[0][:60]}', are not separated by commas"
        if len(cells) != len(names):
            return f"{path}, line {number}: {len(cells)} values where the header names {len(names)} columns"
        for name, cell in zip(names, cells):
            if not is_number(cell):
                return f"{path}, line {number}: column {name} needs a number, not '{cell.strip()}'"
    return f"{path}: the rows cannot be read as numbers"


def write_table(path, names, rows, head=()):
    """Write rows (sequences as long as names) as CSV, whole or not at all; reals with 12 digits, None as empty. head: comments
    above the header row."""
    def shown(value):
        if value is None:
            return ""
        return f"{value:.12g}" if isinstance(value, (float, np.floating)) else value
    with whole(path) as part, open(part, "w", newline="", encoding="utf-8") as stream:
        stream.writelines(f"# {line}\n" for line in head)
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(names)
        writer.writerows([shown(value) for value in row] for row in rows)


def write_text(path, text):
    """Write a text, whole or not at all."""
    with whole(path) as part:
        part.write_text(text, encoding="utf-8")


@contextlib.contextmanager
def whole(path):
    """The name to write a file under, which then replaces the file: who reads it, or stops the program, never meets half of one."""
    part = Path(f"{path}.part")
    try:
        yield part
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
