"""What lib/ and scripts/ offer a case, and what a driver needs of one: the names that the cases of this driver set."""

import functools
import re
from collections import Counter

from tools.base.command import ROOT
from tools.compile_errors import lexer
from tools.compile_errors.names import Declared, declared, fespaces, included, reached

COMMON = "lib/case.idp"  # what every case includes first


@functools.cache
def text_of(path):
    """The text of a file of the project."""
    return (ROOT / path).read_text()


@functools.cache
def script_of(path):
    """A file of the project, taken apart."""
    return lexer.read(text_of(path))


@functools.cache
def spaces():
    """Names of the finite-element spaces of the project."""
    return frozenset().union(*(fespaces(text_of(path)) for path in [*library(), *cases()]))


@functools.cache
def library():
    """The files of lib/ and scripts/, paths from the root."""
    return tuple(
        sorted(
            str(file.relative_to(ROOT))
            for folder in ("lib", "scripts")
            for file in (ROOT / folder).rglob("*.*p")
            if "renamed" not in file.parts
        )
    )


@functools.cache
def cases():
    """The cases of the project, the template first."""
    return tuple(
        sorted(
            (str(file.relative_to(ROOT)) for file in (ROOT / "cases").glob("*.edp")),
            key=lambda path: (path != "cases/template.edp", path),
        )
    )


@functools.cache
def drivers():
    """The drivers: what a case includes of scripts/."""
    return tuple(path for path in library() if path.startswith("scripts/") and path.endswith(".edp"))


def of_macros(macros):
    """Macros as declarations."""
    return [
        Declared(
            macro.name,
            "macro",
            macro.line,
            0,
            None if macro.parameters is None else tuple(macro.parameters),
            f"macro {macro.name}({', '.join(macro.parameters or ())})",
        )
        for macro in macros
    ]


@functools.cache
def declared_in(path):
    """What a file of the project declares, its macros with the rest."""
    script = script_of(path)
    return declared(script.tokens, spaces()) + of_macros(script.macros)


@functools.cache
def offered():
    """{name: [(path, Declared)]} of all that lib/ and scripts/ declare for what follows them."""
    found = {}
    for path in library():
        for one in declared_in(path):
            if one.depth == 0:
                found.setdefault(one.name, []).append((path, one))
    return found


@functools.cache
def words_of(path):
    """{word: the first line} of a file of the project, macros with the rest."""
    found = {}
    for tokens in script_of(path).lists():
        for token in tokens:
            if token.kind == "name":
                found[token.text] = min(found.get(token.text, token.line), token.line)
    return found


@functools.cache
def names_of(path):
    """The names that a file of the project declares at any depth, parameters and names within macros with the rest."""
    script = script_of(path)
    inner = [one.name for macro in script.macros for one in declared(macro.body, spaces())]
    return frozenset(
        [one.name for one in declared_in(path)] + inner + [name for macro in script.macros for name in macro.parameters or ()]
    )


@functools.cache
def hooks():
    """{name: parameters} of the macros that a case may define, as lib/ and scripts/ define them where it does not."""
    named = {name for path in library() for name in re.findall(r"IFMACRO\(!(\w+)\)\s+macro \1\b", text_of(path))}
    return {name: one.parameters for name in named for path, one in offered().get(name, []) if one.kind == "macro"}


@functools.cache
def examples(driver):
    """{name: [(case, Declared)]} of what the cases of this driver declare, the template first; None: of what all cases declare."""
    found = {}
    for path in cases():
        if driver is None or driver in included(text_of(path)):
            for one in declared_in(path):
                if one.depth == 0:
                    found.setdefault(one.name, []).append((path, one))
    return found


@functools.cache
def always(driver):
    """The names that every case of a driver declares for it."""
    count = sum(driver in included(text_of(path)) for path in cases())
    return frozenset(
        name
        for name, found in examples(driver).items()
        if len({path for path, _ in found}) == count and any(name in words_of(path) for path in reached_from((driver,)))
    )


@functools.cache
def reached_from(paths):
    """All files of the project that these include, directly or not, with themselves."""
    return frozenset(reached(paths))


def endings(name, driver):
    """The last words of this macro's bodies in the cases of the driver and in the project's defaults; "" of an empty one."""
    paths = [path for path in cases() if driver is None or driver in included(text_of(path))] + list(library())
    return {macro.body[-1].text if macro.body else "" for path in paths for macro in script_of(path).macros if macro.name == name}


def distance(first, second):
    """Edit distance of two words: letters more, less, others, swapped; capital instead of small counts a half."""
    rows = [[float(column) for column in range(len(second) + 1)]]
    for i, a in enumerate(first, 1):
        row = [float(i)]
        for j, b in enumerate(second, 1):
            cost = 0 if a == b else 0.5 if a.lower() == b.lower() else 1
            best = min(rows[-1][j] + 1, row[-1] + 1, rows[-1][j - 1] + cost)
            if i > 1 and j > 1 and a == second[j - 2] and b == first[i - 2]:
                best = min(best, rows[-2][j - 2] + 1)
            row.append(best)
        rows.append(row)
    return rows[-1][-1]


def nearest(word, choices, share=0.34, preferred=()):
    """The choice that is nearest to a word, one of the preferred among equals; None where more than this share differs."""
    letters, limit = Counter(word.lower()), max(1, share * len(word))

    def letters_of_their_own(other):
        """At most the distance, and found in a fraction of its time."""
        return max(len(word), len(other)) - sum((letters & Counter(other.lower())).values())

    near = [
        (distance(word, other), other not in preferred, other)
        for other in choices
        if other != word and abs(len(other) - len(word)) <= 3 and letters_of_their_own(other) <= limit
    ]
    most, _, best = min(near, default=(99, True, None))
    return best if most <= limit else None
