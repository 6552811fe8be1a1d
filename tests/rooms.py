"""Reading the rooms of lib/: which names a file declares, uses and writes, and what its header says about them."""

import re
import textwrap
from functools import lru_cache

from tests.lint import files
from tools.base.command import ROOT
from tools.compile_errors.lexer import words
from tools.compile_errors.names import bare, declared, fespaces, included

PAGE = ROOT / "CONTRIBUTING.md"
LONGEST = 132  # characters in a line
ASSIGNED = re.compile(r"\s*(?:\.resize\s*\([^;=]*?\)\s*)?(?:\.\*|\./|[-+*/])?=(?!=)|\s*(?:\+\+|--|\.resize\b|\.coef\s*=|\.diag\s*=)")
FILLED_BY_LANGUAGE = {"sort": {0, 1}}  # functions of the language that change their arguments
NOT_CALLS = {"if", "for", "while", "return", "func", "macro", "varf"}


def rooms(page):
    """The rooms in the table of a page, floor by floor: its rows begin with | `lib/ROOM/` |."""
    return re.findall(r"^\| *`lib/(\w+)/` *\|", page, flags=re.M)


def room(path):
    """lib/ROOM/FILE.idp -> ROOM; "" of a file that stands in no room."""
    found = re.fullmatch(r"lib/(\w+)/\w+\.idp", path)
    return found.group(1) if found else ""


def texts():
    """{path: text} of lib/, without the one include of a case and the old names of files, and of the drivers."""
    paths = [path for path in files(".idp") + files(".edp") if path.startswith(("lib/", "scripts/"))]
    return {path: (ROOT / path).read_text() for path in paths if path != "lib/case.idp" and "/renamed/" not in path}


def header_says(text, what):
    """The text after "// WHAT:" in the header, with the indented lines that continue it, as one line."""
    found = re.search(rf"^// {what}:((?:.*\n)(?:^//  .*\n)*)", text.split("\nIFMACRO")[0] + "\n", flags=re.M)
    return re.sub(r"\s*\n//\s*", " ", found.group(1)).strip() if found else ""


def called_back(text):
    """Names that a file calls and leaves to its users to define, as "// Calls back: a, b" in its header says."""
    return set(re.findall(r"\w+", header_says(text, "Calls back")))


def written_by(text):
    """{file: names}, as "// Written by: lib/room/file.idp (names), ..." in the header of a file says."""
    return {file: set(re.findall(r"\w+", names)) for file, names in re.findall(r"([\w/]+\.\w+) \(([^)]*)\)",
        header_says(text, "Written by"))}


def written_line(others):
    """The lines "// Written by: ..." of {file: names}."""
    text = ", ".join(f"{file} ({', '.join(sorted(names))})" for file, names in sorted(others.items()))
    return textwrap.fill("// Written by: " + text, LONGEST, subsequent_indent="//   ", break_long_words=False,
        break_on_hyphens=False)


def closing(text, at):
    """The place after the bracket that closes the one before `at`."""
    depth = 1
    while depth and at < len(text):
        depth += (text[at] in "([{") - (text[at] in ")]}")
        at += 1
    return at


def parts(text):
    """The parts of `a, f(b, c), d[1, 2]` between the outer commas, stripped."""
    found, depth, begin = [], 0, 0
    for at, letter in enumerate(text):
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0:
            found.append(text[begin:at].strip())
            begin = at + 1
    last = text[begin:].strip()
    return found + [last] if last else found


@lru_cache(maxsize=None)
def functions(text):
    """The functions, and the macros with parameters, that a script defines: {name: (parameters, body)}."""
    found = {}
    plain = re.sub(r"/\*.*?\*/", " ", re.sub(r'"(\\.|[^"\\\n])*"', '""', text), flags=re.S)
    for head in re.finditer(r"\bmacro\s+(\w+)\s*\(([^)]*)\)", plain):
        found[head.group(1)] = parts(head.group(2)), plain[head.end() : plain.find("//", head.end())]
    plain = bare(text)
    for head in re.finditer(r"\bfunc\s+\w+(?:\s*\[[^\]]*\])*\s+(\w+)\s*\(", plain):
        end = closing(plain, head.end())
        body = re.compile(r"\s*\{").match(plain, end)
        if body:
            names = [re.findall(r"\w+", part)[-1] for part in parts(plain[head.end() : end - 1])]
            found[head.group(1)] = names, plain[body.end() : closing(plain, body.end())]
    return found


@lru_cache(maxsize=None)
def calls(text):
    """Calls in a script without comments: (name of the function, its arguments)."""
    return [(head.group(1), parts(text[head.end() : closing(text, head.end()) - 1]))
            for head in re.finditer(r"(?<![\w.])([A-Za-z_]\w*)\s*\(", text) if head.group(1) not in NOT_CALLS]


@lru_cache(maxsize=None)
def assigned(text):
    """Names that the statements of a script without comments assign, resize, count up or read from a file."""
    found = set()
    text = re.sub(r"(?m)^\s*(?:IFMACRO|ENDIFMACRO)\b.*$", "", text)
    for word in re.finditer(r"(?<![\w.])[A-Za-z_]\w*", text):
        at = word.end()
        while opened := re.compile(r"\s*[\[(]").match(text, at):
            at = closing(text, opened.end())
        if ASSIGNED.match(text, at) or re.search(r"(?:\+\+|--|>>)\s*$", text[max(0, word.start() - 8) : word.start()]):
            found.add(word.group())
    for several in re.findall(r"\[([\w\s,]+)\]\s*=(?!=)", text):  # [I, J, C] = A
        found |= set(re.findall(r"\w+", several))
    return found


def filled(defined):
    """Which arguments functions fill, {name: places}, of {name: (parameters, body)}; one that passes an argument on to such a
    function too."""
    places = dict(FILLED_BY_LANGUAGE)
    for name, (parameters, body) in defined.items():
        names = assigned(body)
        places[name] = {at for at, parameter in enumerate(parameters) if parameter in names}
    inner = {name: calls(body) for name, (_, body) in defined.items()}
    before = None
    while before != (now := sum(map(len, places.values()))):
        before = now
        for name, (parameters, _) in defined.items():
            for called, arguments in inner[name]:
                places[name] |= {parameters.index(arguments[at]) for at in places.get(called, ()) if at < len(arguments)
                    and arguments[at] in parameters}
    return places


def written(text, places):
    """Names that a script writes: assigns, or passes to functions that fill them (places: of `filled`)."""
    text = bare(text)
    names = set(assigned(text))
    for called, arguments in calls(text):
        names |= {arguments[at] for at in places.get(called, ()) if at < len(arguments) and re.fullmatch(r"\w+", arguments[at])}
    return names


@lru_cache(maxsize=None)
def declared_in(text, spaces):
    """What a script declares; spaces: a frozenset of the names of its finite element spaces."""
    return declared(words(bare(text))[0], spaces)


@lru_cache(maxsize=None)
def names_in(text):
    """All names in a script without comments and texts."""
    return frozenset(re.findall(r"(?<![\w.])[A-Za-z_]\w*", bare(text)))


class Library:
    """What the files of lib/ declare, use and write, and the drivers write. given: {path: text}."""

    def __init__(self, given):
        self.given = given
        self.files = [path for path in given if path.startswith("lib/")]
        self.spaces = spaces = set().union(*(fespaces(text) for text in given.values()))
        found = {path: declared_in(text, frozenset(spaces)) for path, text in given.items()}
        self.local = {path: {each.name for each in found[path]} for path in given}  # at any depth
        self.outer = {path: {each.name for each in found[path] if each.depth == 0} for path in given}  # outside all braces
        self.owners = {}  # of those
        for path in self.files:
            for name in self.outer[path]:
                self.owners.setdefault(name, set()).add(path)
        self.defined = {}
        for path in given:
            self.defined |= functions(given[path])
        self.places = filled(self.defined)

    def foreign(self, path, names):
        """Of these names, those that other files of lib/ declare and this one does not, at any depth."""
        inner = set().union(*(parameters for parameters, _ in functions(self.given[path]).values())) | self.local[path]
        return {name for name in names if name in self.owners and name not in inner}

    def used(self, path):
        """Names that a file takes from others."""
        text = re.sub(r"(?m)^\s*IFMACRO\([^)]*\)", "", self.given[path])
        return self.foreign(path, names_in(text)) - called_back(text)

    def upward(self, floors):
        """What points to a higher room: (file, include or name, where that stands)."""
        found = []
        for path in self.files:
            if room(path) not in floors:
                continue
            own = floors.index(room(path))
            higher = {other for other in self.files if room(other) in floors[own + 1 :]}
            found += [(path, "include", other) for other in included(self.given[path]) if other in higher]
            found += [(path, name, min(self.owners[name])) for name in sorted(self.used(path)) if self.owners[name] <= higher]
        return found

    def circles(self):
        """Files that use names of each other, directly or through others: a list of sorted lists."""
        takes = {path: {other for name in self.used(path) for other in self.owners[name] if len(self.owners[name]) == 1}
            for path in self.files}
        reach = {}
        for path in self.files:
            seen, open_ends = set(), [path]
            while open_ends:
                fresh = takes[open_ends.pop()] - seen
                seen |= fresh
                open_ends += fresh
            reach[path] = seen
        return sorted({tuple(sorted({path} | {other for other in reach[path] if path in reach[other]})) for path in self.files
            if path in reach[path]})

    def unreached(self):
        """Names that a file uses although neither its includes nor the files it needs before it, with theirs, declare them: (file, name)."""
        found = []
        for path in self.files:
            known, open_ends = set(), [path, *re.findall(r"lib/[\w/]+\.idp", header_says(self.given[path], "Needs"))]
            while open_ends:
                one = open_ends.pop()
                if one in self.given and one not in known:
                    known.add(one)
                    open_ends += included(self.given[one])
            found += [(path, name) for name in sorted(self.used(path)) if not self.owners[name] & known]
        return found

    def writers(self):
        """{file: {other file: names}}: who else writes what a file of lib/ declares."""
        found = {path: {} for path in self.files}
        for path in self.given:
            for name in self.foreign(path, written(self.given[path], self.places) - self.spaces):
                if len(self.owners[name]) == 1:
                    found[min(self.owners[name])].setdefault(path, set()).add(name)
        return found
