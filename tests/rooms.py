"""Reading the rooms of lib/: which names a file declares, uses and writes, and what its header says about them."""
import re
from functools import cache

from tests.lint import ROOT, bare, fespaces, files, global_names

PAGE = "CONTRIBUTING.md"
ASSIGNED = r"\s*(?:\.resize\s*\([^;=]*?\)\s*)?(?:\.\*|\./|[-+*/])?=(?!=)"
FILLED_BY_LANGUAGE = {"sort": (0, 1)}  # functions of the language that change their arguments
NOT_CALLS = {"if", "for", "while", "return", "func", "macro", "varf"}


def rooms(page):
    """Names of the rooms in the table of the page, floor by floor: rows that begin with | `lib/ROOM/` |."""
    return re.findall(r"^\| *`lib/(\w+)/` *\|", page, flags=re.M)


def files_of_lib():
    """The files of the rooms: all of lib/ but the one include of a case and the old names of files."""
    return [path for path in files(".idp") if path.startswith("lib/") and path != "lib/case.idp" and not path.startswith("lib/core/renamed/")]


def room(path):
    """lib/ROOM/FILE.idp -> ROOM; "" of a file that stands in no room."""
    found = re.fullmatch(r"lib/(\w+)/\w+\.idp", path)
    return found.group(1) if found else ""


def without_words(text):
    """The script without strings and comments between /* and */; the ends of macros (//) stay."""
    return re.sub(r"/\*.*?\*/", " ", re.sub(r'"(\\.|[^"\\\n])*"', '""', text), flags=re.S)


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


def functions(text):
    """The functions and macros with parameters that a script defines: {name: (parameters, body)}."""
    found, text = {}, without_words(text)
    for head in re.finditer(r"\bmacro\s+(\w+)\s*\(([^)]*)\)", text):
        end = text.find("//", head.end())
        found[head.group(1)] = [part.strip() for part in head.group(2).split(",")], text[head.end() : end]
    text = re.sub(r"//[^\n]*", ";", text)
    for head in re.finditer(r"\bfunc\s+\w+(?:\s*\[[^\]]*\])*\s+(\w+)\s*\(", text):
        end = closing(text, head.end())
        body = re.compile(r"\s*\{").match(text, end)
        if body:
            names = [re.findall(r"\w+", part)[-1] for part in parts(text[head.end() : end - 1])]
            found[head.group(1)] = names, text[body.end() : closing(text, body.end())]
    return found


def assigned(text):
    """Names that statements of a script assign, resize, count up or read from a file."""
    names = set()
    text = re.sub(r"(?m)^\s*(?:IFMACRO|ENDIFMACRO)\b.*$", "", text)
    for word in re.finditer(r"(?<![\w.])[A-Za-z_]\w*", text):
        name, at = word.group(), word.end()
        rest = re.compile(r"\s*[\[(]")
        while (opened := rest.match(text, at)) and text[word.start() - 1 : word.start()] != "&":
            at = closing(text, opened.end())
        if re.compile(ASSIGNED).match(text, at) or re.compile(r"\s*(?:\+\+|--|\.resize\b|\.coef\s*=)").match(text, at):
            names.add(name)
        elif re.search(r"(?:\+\+|--|>>)\s*$", text[: word.start()][-8:]):
            names.add(name)
    for several in re.findall(r"\[([\w\s,]+)\]\s*=(?!=)", text):  # [I, J, C] = A
        names |= set(re.findall(r"\w+", several))
    return names


def calls(text):
    """Calls in a script: (name of the function, its arguments)."""
    found = []
    for head in re.finditer(r"(?<![\w.])([A-Za-z_]\w*)\s*\(", text):
        if head.group(1) not in NOT_CALLS:
            found.append((head.group(1), parts(text[head.end() : closing(text, head.end()) - 1])))
    return found


def filled(defined):
    """Which arguments functions fill: {name: places}, of {name: (parameters, body)}; a function that passes one on to such a function too."""
    places = {name: set(many) for name, many in FILLED_BY_LANGUAGE.items()}
    for name, (parameters, body) in defined.items():
        written = assigned(body)
        places[name] = {at for at, parameter in enumerate(parameters) if parameter in written}
    inner = {name: calls(body) for name, (_, body) in defined.items()}
    before = None
    while before != (now := sum(map(len, places.values()))):
        before = now
        for name, (parameters, _) in defined.items():
            for called, arguments in inner[name]:
                for at in places.get(called, ()):
                    if at < len(arguments) and arguments[at] in parameters:
                        places[name].add(parameters.index(arguments[at]))
    return places


def written(text, places):
    """Names that a script writes: assigned, or passed to functions that fill them (places: of `filled`)."""
    text = re.sub(r"//[^\n]*", ";", without_words(text))
    names = assigned(text)
    for called, arguments in calls(text):
        names |= {arguments[at] for at in places.get(called, ()) if at < len(arguments) and re.fullmatch(r"\w+", arguments[at])}
    return names


def used(text):
    """All words of a script that are no members of something."""
    return set(re.findall(r"(?<![\w.])[A-Za-z_]\w*", bare(text)))


def header_lines(text, what):
    """The text after "// WHAT:" in the header, with the indented lines that continue it."""
    found = re.search(rf"^// {what}:((?:.*\n)(?:^//  .*\n)*)", text, flags=re.M)
    return re.sub(r"\n//", " ", found.group(1)) if found else ""


def allowed(text, what):
    """{file: names} of a header line "// WHAT: lib/room/file.idp (names), ..."."""
    return {file: set(re.findall(r"\w+", names)) for file, names in re.findall(r"(\w[\w/]+\.\w+) \(([^)]*)\)", header_lines(text, what))}
