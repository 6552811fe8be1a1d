"""A FreeFEM script as words and signs with their lines, its macros, and what is amiss with its brackets, quotes and comments.

A macro is text up to the next two slashes, whatever stands in between; it is read apart from the statements around it.
"""

import re
from dataclasses import dataclass, field
from typing import NamedTuple

WORDS = re.compile(
    r"""
    (?P<space>\s+) | (?P<comment>//[^\n]*|/\*.*?\*/) | (?P<open>/\*) |
    (?P<string>"(?:\\.|[^"\\\n])*") | (?P<quote>") |
    (?P<number>(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d*)?i?) | (?P<name>[A-Za-z]\w*) |
    (?P<sign>\.\*=|\./=|<<|>>|<=|>=|==|!=|&&|\|\||\+\+|--|->|\+=|-=|\*=|/=|:=|<>|\.\*|\./|[][(){}<>=+\-*/^%.,;:?!&|'~#_@$\\]) |
    (?P<other>.)""",
    re.X | re.S | re.A,
)
CLOSING = {")": "(", "]": "[", "}": "{"}
BEGINNINGS = frozenset(
    "int real bool string mesh matrix fespace varf func if for while".split()
)  # of a statement that does not belong to a value
PLAIN_END = re.compile(r"//\s*(EOM|eom|end\b.*)?\s*$")


class Token(NamedTuple):
    """A word, number, text or sign, and its line (the first is 1)."""

    kind: str
    text: str
    line: int
    indent: int = 0  # of its line


@dataclass(frozen=True)
class Fault:
    """What is amiss, and the line where the reader of the script finds it."""

    line: int
    text: str


@dataclass
class Macro:
    """A macro: its parameters (None: written without parentheses), the words of its body, its lines, the comment that ends it.

    end: "" where the file ends before the macro does.
    """

    name: str
    parameters: list
    body: list
    line: int
    last: int
    end: str
    faults: list = field(default_factory=list)


@dataclass
class Script:
    """A script: the words outside macros, the macros, and the faults in the order of their lines."""

    tokens: list
    macros: list
    faults: list

    def lists(self):
        """The words of each part that is read apart: the statements, each macro's body."""
        return [self.tokens, *(macro.body for macro in self.macros)]


def words(text, line=1):
    """The tokens of a text that begins in this line, its comments as (line, text), and faults of quotes and comments."""
    tokens, comments, faults = [], [], []
    indents = [len(row) - len(row.lstrip()) for row in text.split("\n")]
    first, at = line, 0
    while at < len(text):
        match = WORDS.match(text, at)
        kind, word = match.lastgroup, match.group()
        at = match.end()
        if kind == "comment":
            comments.append((line, word))
        elif kind == "open":
            faults.append(Fault(line, "the comment that /* begins here is not closed by */"))
            at = len(text)
        elif kind == "quote":
            rest = text[match.start() :].split("\n")[0]
            faults.append(
                Fault(line, f"the quote \" before {shown(rest[1:])} opens a text that no second quote closes in this line")
            )
            tokens.append(Token("string", rest, line, indents[line - first]))
            at = match.start() + len(rest)
        elif kind == "other":
            faults.append(
                Fault(
                    line,
                    f"the sign {word} ({'U+%04X' % ord(word)}) is none of FreeFEM's: outside of comments it takes plain"
                    " letters, figures and signs",
                )
            )
        elif kind != "space":
            if kind == "string" and not word.isascii():
                sign = next(one for one in word if not one.isascii())
                faults.append(
                    Fault(
                        line,
                        f"the text {shown(word)} has {sign} ({'U+%04X' % ord(sign)}), which FreeFEM reads in comments alone; a side"
                        " with such a name has a label, a number, too",
                    )
                )
            if kind == "name" and "_" in word:
                faults.append(
                    Fault(
                        line,
                        f"the name {word} has an underscore, which FreeFEM's names cannot have: call it"
                        f" {without_underscores(word)}",
                    )
                )
            if word == "'" and (not tokens or tokens[-1].text in "(,=<<+"):
                faults.append(Fault(line, "a text stands in double quotes \"...\", not in single quotes '"))
            tokens.append(Token(kind, word, line, indents[line - first]))
        line += word.count("\n")
    return tokens, comments, faults


def without_underscores(word):
    """my_speed as mySpeed."""
    first, *rest = [part for part in word.split("_") if part]
    return first + "".join(part[0].upper() + part[1:] for part in rest)


def shown(text, most=24):
    """The beginning of a text, for a sentence."""
    text = " ".join(text.split())
    return text if len(text) <= most else text[:most] + "..."


HEAD = re.compile(r"\s+([A-Za-z]\w*)[ \t]*(?:\(([^()\n]*)\))?", re.A)
SKIPPED = re.compile(r'"(?:\\.|[^"\\\n])*"|//[^\n]*|/\*.*?\*/|(?<![\w.])macro(?=\s)', re.S)


def read(text):
    """A script taken apart."""
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    tokens, macros, faults, comments = [], [], [], []
    if text.startswith("\ufeff"):
        faults.append(Fault(1, "the file begins with a byte-order mark (U+FEFF), which FreeFEM does not read: save it without one"))
        text = text[1:]

    def plain(begin, end):
        found = words(text[begin:end], text.count("\n", 0, begin) + 1)
        for into, new in zip((tokens, comments, faults), found):
            into += new

    at = begin = 0
    while match := SKIPPED.search(text, at):
        at = match.end()
        head = HEAD.match(text, at) if match.group() == "macro" else None
        if not head:
            continue
        plain(begin, match.start())
        line = text.count("\n", 0, match.start()) + 1
        stop = text.find("//", head.end())
        stop = len(text) if stop < 0 else stop
        at = begin = (text.find("\n", stop) + 1 or len(text)) if stop < len(text) else stop
        body, _, amiss = words(text[head.end() : stop], text.count("\n", 0, head.end()) + 1)
        parameters = head.group(2)
        macros.append(
            Macro(
                head.group(1),
                None if parameters is None else [name.strip() for name in parameters.split(",") if name.strip()],
                body,
                line,
                text.count("\n", 0, stop) + 1,
                text[stop:at].strip(),
                amiss,
            )
        )
    plain(begin, len(text))
    for macro in macros:
        faults += macro_faults(macro, comments, macros)
    return Script(tokens, macros, sorted(faults + brackets(tokens), key=lambda fault: fault.line))


def macro_faults(macro, comments, macros):
    """What is amiss with a macro: no end, a comment that ends it, brackets."""
    called = f"the macro {macro.name}"
    following = min((other.line for other in macros if other.line > macro.line), default=1e9)
    left_over = [line for line, said in comments if macro.last < line < following and re.fullmatch(r"//\s*EOM\s*", said)]
    open_brackets = brackets(macro.body)
    strange = not PLAIN_END.match(macro.end)
    if not macro.end or swallows(macro):
        return [Fault(macro.line, f"{called} has no end: // EOM is missing after its last statement")]
    if left_over and (strange or open_brackets) or strange and any("/*" in fault.text for fault in macro.faults):
        return [
            Fault(
                macro.last,
                f"the comment {shown(macro.end)} ends {called} (line {macro.line}) here: within a macro comments are written /*"
                " ... */",
            )
        ]
    if strange and (open_brackets or macro.last > macro.line and surplus(macro.body)):
        return [
            Fault(
                macro.line,
                f"{called} has no end before the comment {shown(macro.end)} of line {macro.last}: // EOM is missing after its last"
                " statement, or this comment stands within it",
            )
        ]
    return macro.faults or [Fault(fault.line, f"{fault.text}, in {called} (line {macro.line})") for fault in open_brackets]


def swallows(macro):
    """Whether a macro's text goes on into what follows it."""
    return any(token.kind == "name" and token.text in ("macro", "include", "load") for token in macro.body)


def surplus(body):
    """Whether more stands behind the braces that hold a macro's body, or another statement behind a body without braces."""
    if not body or body[0].text != "{":
        return any(token.text in BEGINNINGS and first_of_line(body, place) for place, token in enumerate(body) if place)
    depth = 0
    for place, token in enumerate(body):
        depth += (token.text == "{") - (token.text == "}")
        if depth == 0:
            return place + 1 < len(body)
    return False


def brackets(tokens):
    """The first fault of the brackets of these words, in a list; an empty one without any."""
    opened, misplaced = [], None
    for place, token in enumerate(tokens):
        word = token.text if token.kind == "sign" else ""
        if word in ("(", "[", "{") and word:
            before = [one.text for one in tokens[max(place - 2, 0):place]]
            # for (...; ...; ...) and border name(t = 0, 1; i)
            opened.append((token, before[-1:] == ["for"] or before[:1] == ["border"]))
        elif word in CLOSING and word:
            if not opened:
                return [Fault(token.line, f"the {word} here closes nothing")]
            last, _ = opened.pop()
            if last.text != CLOSING[word]:
                if last.text == "{":
                    return [Fault(token.line, f"the {word} here closes nothing")]
                return [
                    Fault(
                        last.line,
                        f"the {last.text} here is not closed before the {word}"
                        + (f" of line {token.line}" if token.line != last.line else ""),
                    )
                ]
            if (
                word == "}"
                and misplaced is None
                and last.line < token.line
                and first_of_line(tokens, place)
                and last.indent != token.indent
            ):
                misplaced = last
        elif word == ";" and opened and opened[-1][0].text in "([" and not opened[-1][1]:
            return [
                Fault(
                    opened[-1][0].line,
                    f"the {opened[-1][0].text} here is not closed before the ;"
                    + (f" of line {token.line}" if token.line != opened[-1][0].line else ""),
                )
            ]
    if not opened:
        return []
    left = opened[-1][0]
    if left.text == "{" and misplaced is not None and misplaced.line > left.line:
        left = misplaced
    return [Fault(left.line, f"the {left.text} here is not closed")]


def first_of_line(tokens, place):
    """Whether a token begins its line."""
    return place == 0 or tokens[place - 1].line < tokens[place].line
