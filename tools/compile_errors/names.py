"""What a FreeFEM script includes, declares and calls, read from its text."""

import re
from dataclasses import dataclass

from tools.base.command import ROOT
from tools.compile_errors.lexer import Token, words

# Words of the language that a variable of the same name replaces in silence.
FORBIDDEN = set("x y z N P t area label region hTriangle lenEdge volume dx dy mean jump pi nuTriangle".split())
TYPES = frozenset(
    "int real bool complex string mesh mesh3 meshL meshS matrix border varf func fespace macro ofstream ifstream".split()
)


def bare(text):
    """The script without strings and comments; a macro's end stays as a line's end."""
    text = re.sub(r'"(\\.|[^"\\\n])*"', '""', text)
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
    return re.sub(r"//[^\n]*", ";", text)


def included(text):
    """The names in the include lines of a script."""
    return re.findall(r'include\s+"([^"]+)"', re.sub(r"^\s*//.*$", "", text, flags=re.M))


def includes(path):
    """The files of the project that a script includes, paths from the root."""
    return [name for name in included((ROOT / path).read_text()) if (ROOT / name).is_file()]


def reached(paths):
    """All that these scripts include, directly or not, with themselves."""
    found, open_ends = set(), list(paths)
    while open_ends:
        path = open_ends.pop()
        if path not in found:
            found.add(path)
            open_ends += includes(path)
    return found


@dataclass(frozen=True)
class Declared:
    """A name that a script declares. kind: as written, such as int[int] or func real; depth: braces and parentheses around it;
    parameters: of a func or macro, as written, None of anything else; text: the words of its declaration."""

    name: str
    kind: str
    line: int
    depth: int
    parameters: tuple = None
    text: str = ""


def fespaces(text):
    """Names of the finite-element spaces that a script declares."""
    return set(re.findall(r"\bfespace\s+(\w+)", bare(text)))


def global_names(text, spaces=()):
    """Names that a script declares for all that follow: variables, functions, macros."""
    return {found.name for found in declared(words(bare(text))[0], spaces) if found.depth == 0}


def declared(tokens, spaces=()):
    """What these words declare, at any depth, in their order.

    spaces: names of finite-element spaces beside those that they declare themselves.
    """
    types = TYPES.union(spaces, (after.text for token, after in zip(tokens, tokens[1:]) if token.text == "fespace"))
    found, depth, place = [], 0, 0
    end = Token("sign", "", 0)
    at = lambda number: tokens[number] if 0 <= number < len(tokens) else end  # noqa: E731
    while place < len(tokens):
        token = tokens[place]
        depth -= token.text in (")", "}") and token.kind == "sign"
        if token.kind == "name" and token.text in types and at(place - 1).text != ".":
            kind, after = kind_of(tokens, place, types)
            if at(after).kind == "name":
                found += declarators(tokens, after, kind, depth)
            elif kind == token.text + "[...]" and at(after).text in ("=", ";"):  # Vh [u, v];
                found += [
                    Declared(one.text, token.text, one.line, depth)
                    for one in tokens[place:after]
                    if one.kind == "name" and one is not token
                ]
            place = max(after, place + 1)
            continue
        depth += token.text in ("(", "{") and token.kind == "sign"
        place += 1
    return found


def kind_of(tokens, place, types):
    """The kind that is written from here on, as int[int], func real[int], real[int] &, and the place behind it."""
    kind, word = tokens[place].text, tokens[place].text
    place += 1
    for _ in range(2):
        while place < len(tokens) and tokens[place].text in ("[", "<"):
            closing = "]" if tokens[place].text == "[" else ">"
            stop = place
            while stop < len(tokens) and tokens[stop].text != closing:
                stop += 1
            inner = [token.text for token in tokens[place + 1 : stop]]
            kind += (
                tokens[place].text
                + (", ".join(one for one in inner if one != ",") if set(inner) <= types | {","} else "...")
                + closing
            )
            place = stop + 1
        if word == "func" and place < len(tokens) and tokens[place].text in types:
            kind, word = kind + " " + tokens[place].text, ""
            place += 1
        else:
            break
    if place < len(tokens) and tokens[place].text == "&":
        place += 1
    return kind, place


def declarators(tokens, place, kind, depth):
    """The names in `a = f(), b[3], c();` up to the end of the statement; a body ends it too."""
    found, expecting, inner, begin = [], True, 0, place
    while place < len(tokens):
        token = tokens[place]
        word = token.text if token.kind == "sign" else ""
        if word in (";", "}", "{") and word and inner == 0 or inner < 0:
            break
        if word == "," and inner == 0:
            expecting = True
        elif expecting and inner == 0:
            if token.kind != "name" or token.text in TYPES and found:  # the next parameter of a function
                break
            found.append(
                (
                    place,
                    Declared(
                        token.text,
                        kind,
                        token.line,
                        depth,
                        parameters(tokens, place) if kind.startswith(("func", "macro")) else None,
                    ),
                )
            )
            expecting = False
        inner += (word in ("(", "[", "{")) - (word in (")", "]", "}")) if word else 0
        place += 1
    ends = [other for other, _ in found[1:]] + [place]
    return (
        [
            Declared(one.name, one.kind, one.line, one.depth, one.parameters, written(kind, tokens[first : max(first + 1, stop)]))
            for (first, one), stop in zip(found, ends)
        ]
        if begin < place
        else []
    )


def written(kind, tokens):
    """A declaration as text."""
    return f"{kind} {spelled(tokens).rstrip(', ')}"


def spelled(tokens):
    """Tokens as text, with blanks where one writes them."""
    text = ""
    for token in tokens:
        wide = text[-1:] in (",", "=", "&") or token.text in ("=", "&") or text[-1:].isalnum() and token.text[0].isalnum()
        text += (" " if text and (wide or text[-1:] == "]" and token.kind == "name") else "") + token.text
    return text


def parameters(tokens, place):
    """The parameters behind a name, each as written, in a tuple; None where no parenthesis follows."""
    if place + 1 >= len(tokens) or tokens[place + 1].text != "(":
        return None
    return tuple(spelled(one) for one in arguments(tokens, place + 1)[0])


def arguments(tokens, place):
    """What stands in the parenthesis that opens at this place: a list of tokens for each argument; and the place of its end."""
    depth, found, current = 0, [], []
    while place < len(tokens):
        token = tokens[place]
        word = token.text if token.kind == "sign" else ""
        depth -= word in (")", "]", "}") and word != ""
        if depth == 0 and word == ")":
            break
        if depth == 1 and word == ",":
            found.append(current)
            current = []
        elif depth > 0:
            current.append(token)
        depth += word in ("(", "[", "{") and word != ""
        place += 1
    return (found + [current] if found or current else []), place
