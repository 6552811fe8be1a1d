"""Reading FreeFEM scripts as text: what they include, which global names they declare."""
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("cases", "scripts", "lib", "tools", "tests")

# Words of the language that a variable of the same name replaces in silence.
FORBIDDEN = set("x y z N P t area label region hTriangle lenEdge volume dx dy mean jump".split())
TYPES = "int|real|bool|complex|string|mesh|mesh3|meshL|meshS|matrix|border|varf|func|fespace|macro|ofstream|ifstream"


def files(ending):
    """Paths from the root of the scripts with this ending, sorted; without the old names of drivers, which are no scripts of their own."""
    return sorted(str(f.relative_to(ROOT)) for folder in FOLDERS for f in (ROOT / folder).rglob(f"*{ending}") if "renamed/scripts" not in str(f))


def bare(text):
    """The script without strings and comments; a macro's end stays as a line's end."""
    text = re.sub(r'"(\\.|[^"\\\n])*"', '""', text)
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
    return re.sub(r"//[^\n]*", ";", text)


def includes(path):
    """The files of the project that a script includes, paths from the root."""
    text = re.sub(r"^\s*//.*$", "", (ROOT / path).read_text(), flags=re.M)
    return [name for name in re.findall(r'include\s+"([^"]+)"', text) if (ROOT / name).is_file()]


def reached(paths):
    """All that these scripts include, directly or not, with themselves."""
    found, open_ends = set(), list(paths)
    while open_ends:
        path = open_ends.pop()
        if path not in found:
            found.add(path)
            open_ends += includes(path)
    return found


def needed(path):
    """The lib/ files that the header line "// Needs: ..." of a file names."""
    header = re.search(r"^// Needs:((?:.*\n)(?:^//   .*\n)*)", (ROOT / path).read_text(), flags=re.M)
    return re.findall(r"lib/[\w/]+\.idp", header.group(1)) if header else []


def fespaces(text):
    """Names of the finite-element spaces that a script declares."""
    return set(re.findall(r"\bfespace\s+(\w+)", bare(text)))


def outermost(text):
    """What stands outside all braces and parentheses: the global statements."""
    kept, depth = [], 0
    for letter in text:
        depth -= letter in ")}"
        if depth == 0:
            kept.append(letter)
        depth += letter in "({"
    return "".join(kept)


def global_names(text, spaces=()):
    """Names that a script declares for all that follow: variables, functions, macros."""
    text = outermost(bare(text))
    types = "|".join([TYPES, *map(re.escape, spaces)])
    suffix = r"(?:\s*<\w+>)?(?:\s*\[[\w\s,]*\])?(?:\s+(?:" + types + r")(?:\s*\[[\w\s,]*\])?)?"
    names = set()
    for match in re.finditer(rf"(?<![\w.])(?:{types}){suffix}\s+(?=[A-Za-z_])", text):
        names |= set(declarators(text[match.end() :]))
    for match in re.finditer(rf"(?<![\w.])(?:{types})\s*\[([\w\s,]+)\]\s*(?:=|;)", text):  # Vh [u, v];
        names |= set(re.findall(r"\w+", match.group(1)))
    return names


def declarators(rest):
    """The names in `a = f(), b[3], c();` up to the end of the statement; a body ends it too."""
    names, expecting, brackets = [], True, 0
    for token in re.finditer(r"[A-Za-z_]\w*|[][;,}]", rest):
        word = token.group()
        if word in ";}" or (word == "," and brackets < 0):
            break
        brackets += (word == "[") - (word == "]")
        if word == "," and brackets == 0:
            expecting = True
        elif word not in "[],":
            if expecting and brackets == 0:
                names.append(word)
            expecting = False
    return names


HOOKS = r"(?<!\w)(?:case[A-Z]\w*|inflowAt)(?!\w)"  # macros of a case, as the drivers call them


def seen_by_hooks(path, inner=False):
    """Names that a script declares within braces round a macro of the case: each hides one that the case calls so.

    inner: the whole file stands within braces where it is included.
    """
    text = re.sub(r"^\s*(?:macro|IFMACRO|ENDIFMACRO|optMacros)\b[^\n]*", "", bare((ROOT / path).read_text()), flags=re.M)
    names = set()
    for hook in re.finditer(HOOKS, text):
        opened, begins = [0] if inner else [], []
        for at, letter in enumerate(text[: hook.start()]):
            if letter == "{":
                begins.append(at + 1)
            elif letter == "}":
                begins.pop()
        for begin in opened + begins:
            block, depth = text[begin : hook.start()], 0
            kept = []
            for letter in block:  # but for the blocks that are closed before the hook, or hold it
                depth += letter == "{"
                if depth <= 0:
                    kept.append(letter)
                depth -= letter == "}"
            names |= global_names("".join(kept))
    return names
