"""What FreeFEM says of a script that does not compile, taken apart."""

import re
from dataclasses import dataclass, field

TEXT, WHOLE, REAL, TRUTH = "a text", "a whole number", "a number", "a truth value"
ARRAYS = {
    "KNIl": "an int[int]",
    "KN_Il": "an int[int]",
    "KNId": "a real[int]",
    "KN_Id": "a real[int]",
    "KNI6String": "a string[int]",
    "KNMId": "a real[int, int]",
    "KNMIl": "an int[int, int]",
}
FORMS = (  # the first that fits tells the kind; a group: the name that it is about
    ("unknown", r"The Identifier (\S+) does not exist"),
    ("exists", r"The identifier (\S+) exists"),
    ("file", r"Error open+ing file (.+?) in:"),
    ("load", r"Load error: (\S+)"),
    ("macro exists", r"ERREUR in macro name:(\S+)"),
    ("macro arguments", r"Error in macro expansion (\w+)"),
    ("macro end", r"in macro (\w+)\s.*?ENDOFFILE"),
    ("macro call", r"we waiting for a '(.)'"),
    ("no function", r"unknown operator (\S+) on type"),
    ("member", r"No operator \.(\w+) for type"),
    ("operator", r"error operator (\S+)"),
    ("syntax", r"syntax error"),
)


@dataclass
class Message:
    """kind: one of FORMS, or other; name: what it is about; file, line, token: where; macro: whose text FreeFEM reads there;
    given: the kinds of what stands around an operator or in a call, choices: those that would do;
    said: FreeFEM's first words on it; hidden: names of the language that declarations hide."""

    kind: str
    name: str
    file: str
    line: int
    token: str
    macro: str
    given: list = field(default_factory=list)
    choices: list = field(default_factory=list)
    said: str = ""
    hidden: frozenset = frozenset()


def read(output):
    """FreeFEM's output as a Message; kind and said are empty where it says nothing of an error."""
    kind, name = next(
        ((kind, (match.groups() or ("",))[0]) for kind, form in FORMS if (match := re.search(form, output, re.S))), ("other", "")
    )
    where = re.search(r"Error line number\s*(\d+)(?:, in file\s+(?:macro:\s*(\w+) in )?(.*?), before\s+token ?(.*))?", output)
    last = re.search(r"line number :(\d+), ?(.*)", output)
    line = int(where.group(1)) if where else int(last.group(1)) if last else 0
    given, choices = [], []
    if match := re.search(r"error operator \S+\s+(<.*)", output):
        given = kinds(match.group(1))
    if kind == "operator" and name == "(":
        choices = [kinds(one) for one in re.findall(r"^\s*\(\s*<.*?> :(.*)\)\s*$", output, re.M)]
    return Message(
        kind,
        name,
        (where and where.group(3) or "").strip(),
        line,
        (where.group(4) or "").strip() if where else last.group(2).strip() if last else "",
        where and where.group(2) or "",
        given,
        choices,
        first_words(output),
        frozenset(re.findall(r"Warning\s+The identifier (\S+) hide a Global identifier", output)),
    )


def kinds(text):
    """`<c>, <Pd>` as words for the kinds of arguments."""
    return [spoken(one) for one in re.findall(r"<([^<>]*)>", text)]


def spoken(code):
    """FreeFEM's code of a type in words."""
    bare = code.removeprefix("P") if code in ("Pd", "Pl", "Pb", "Pc") else code
    if bare in ("c", "d", "l", "b"):
        return {"c": TEXT, "d": REAL, "l": WHOLE, "b": TRUTH}[bare]
    if "basic_string" in code or code in ("6String",):
        return TEXT
    array = re.match(r"P?\d+(KN_?I\w+?|KNMI\w)E?$", code)
    if array and array.group(1).rstrip("E") in ARRAYS:
        return ARRAYS[array.group(1).rstrip("E")]
    return "an array in brackets [...]" if code == "7E_Array" else "something else"


def first_words(output):
    """FreeFEM's reason in one line: what it says of the compile error itself, else its first line that names an error."""
    reason = re.search(r"^Compile error :[ \t]*(\S.*)$", output, re.M)
    if reason and reason.group(1) not in ("lex:", "syntax error"):
        return " ".join(reason.group(1).split())
    lines = [" ".join(line.split()) for line in output.splitlines() if "*** Warning" not in line]
    telling = [line for line in lines if re.search("error|erreur|not exist|exists|no operator|unknown|fail", line, re.I)]
    return next((line for line in telling if not line.startswith(("Error line number", "Compile error", "error Compile"))), "")
