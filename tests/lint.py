"""Reading FreeFEM scripts as text, for the tests: the project's files, what their headers say, what the macros of a case see."""
import re

from tools.base.command import ROOT
from tools.compile_errors.names import bare, global_names

FOLDERS = ("cases", "scripts", "lib", "tools", "tests")


def files(ending):
    """Paths from the root of the scripts with this ending, sorted; without the old names of drivers, which are no scripts of their
    own."""
    return sorted(str(f.relative_to(ROOT)) for folder in FOLDERS for f in (ROOT / folder).rglob(f"*{ending}")
        if "renamed/scripts" not in str(f))


def needed(path):
    """The lib/ files that the header line "// Needs: ..." of a file names."""
    header = re.search(r"^// Needs:((?:.*\n)(?:^//   .*\n)*)", (ROOT / path).read_text(), flags=re.M)
    return re.findall(r"lib/[\w/]+\.idp", header.group(1)) if header else []


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
