"""The files of an OpenFOAM case: dictionaries, lists and fields, as text or binary, plain or gzipped."""
import gzip
import re
from pathlib import Path

import numpy as np

from tools.base.command import BadInput

BLANK = re.compile(rb"(?:\s+|//[^\n]*|/\*.*?\*/)*", re.DOTALL)
WORD = re.compile(rb'"[^"]*"|[^\s{};]+')
LIST = re.compile(rb"nonuniform\s+List<(\w+)>\s*(\d+)\s*(?=[({;])")
LAST = re.compile(rb"\)\s*\)")  # the end of a list of vectors
WIDTH = {"scalar": 1, "vector": 3, "tensor": 9, "symmTensor": 6}


class Foam:
    """The bytes of a file without its header; binary, label and scalar: its form, as numpy's types."""

    def __init__(self, path):
        path = Path(path)
        file = path if path.is_file() else Path(f"{path}.gz")
        try:
            data = gzip.decompress(file.read_bytes()) if file.suffix == ".gz" else file.read_bytes()
        except (OSError, EOFError, gzip.BadGzipFile) as problem:
            raise BadInput(f"cannot read {path}: {getattr(problem, 'strerror', None) or problem}") from None
        head = re.search(rb"FoamFile\s*\{(.*?)\}", data, re.DOTALL)
        self.path, self.data = path, data[head.end():] if head else data
        entry = head[1] if head else b""
        self.binary = re.search(rb"format\s+binary", entry) is not None
        self.label = np.dtype("<i8" if b"label=64" in entry else "<i4")
        self.scalar = np.dtype("<f4" if b"scalar=32" in entry else "<f8")

    def fault(self):
        return BadInput(f"{self.path} is not a whole file of OpenFOAM")

    def skip(self, at):
        return BLANK.match(self.data, at).end()

    def numbers(self, at, kind, count):
        """(values of `count` entries of a list that begins at "(", place behind it): kind: label or a key of WIDTH."""
        width = WIDTH.get(kind, 1)
        if self.binary:
            form = self.label if kind == "label" else self.scalar
            end = at + 1 + count * width * form.itemsize
            if end > len(self.data):
                raise self.fault()
            values = np.frombuffer(self.data, form, count * width, at + 1)
        else:
            last = LAST.search(self.data, at) if width > 1 and count else re.compile(rb"\)").search(self.data, at)
            if not last:
                raise self.fault()
            end = last.end() - 1
            try:
                values = np.array(self.data[at:end].replace(b"(", b" ").replace(b")", b" ").split(), float)
            except ValueError:
                raise self.fault() from None
        if len(values) != count * width:
            raise self.fault()
        values = values.astype(int) if kind == "label" else values.astype(float)
        return values if width == 1 else values.reshape(-1, width), end + 1

    def plain(self, kind):
        """The values of a file that is one list."""
        at = self.skip(0)
        head = re.compile(rb"(\d+)\s*(?=\()").match(self.data, at)
        if not head:
            raise self.fault()
        return self.numbers(head.end(), kind, int(head[1]))[0]

    def faces(self):
        """The corners of the faces, a list of arrays."""
        at = self.skip(0)
        head = re.compile(rb"(\d+)\s*(?=\()").match(self.data, at)
        if not head:
            raise self.fault()
        if self.binary:  # compact: where each face begins, then all corners
            begin, at = self.numbers(head.end(), "label", int(head[1]))
            again = re.compile(rb"\s*(\d+)\s*(?=\()").match(self.data, at)
            corners, _ = self.numbers(again.end(), "label", int(again[1]))
            return np.split(corners, begin[1:-1])
        words = re.findall(rb"(\d+)\s*\(([\d\s]*)\)", self.data[head.end() + 1:])
        found = [np.array(corners.split(), int) for _, corners in words]
        if len(found) != int(head[1]) or any(len(face) != int(count) for face, (count, _) in zip(found, words)):
            raise self.fault()
        return found

    def entries(self, at=0):
        """({keyword: a dict, an array (a list of numbers) or a text}, place behind the closing brace)."""
        found = {}
        while True:
            at = self.skip(at)
            word = WORD.match(self.data, at)
            if not word:
                return found, at + 1
            name, at = word[0].decode("latin-1"), self.skip(word.end())
            if self.data[at:at + 1] == b"{":
                found[name], at = self.entries(at + 1)
                continue
            head = LIST.match(self.data, at)
            if head and self.data[head.end():head.end() + 1] == b"(":
                found[name], at = self.numbers(head.end(), head[1].decode(), int(head[2]))
                if found[name].dtype == int:
                    found[name] = found[name].astype(float)
                at = self.skip(at)
            else:
                end = self.data.find(b";", at)
                if end < 0:
                    return found, len(self.data)
                found[name], at = self.data[at:end].decode("latin-1").strip(), end
                if head:  # many times one value: 5{(0 0 0)}
                    one = np.array(re.sub(r".*\{|[(){}]", " ", found[name]).split(), float)
                    found[name] = np.full((int(head[2]), *(() if len(one) == 1 else (len(one),))), one if len(one) != 1 else one[0])
            at += self.data[at:at + 1] == b";"


def constant(text):
    """The number or vector of "uniform (1 0 0)", as an array; None for other texts."""
    found = re.fullmatch(r"uniform\s+(\([^()]*\)|\S+)", text) if isinstance(text, str) else None
    try:
        return np.array(found[1].strip("()").split(), float) if found else None
    except ValueError:
        return None
