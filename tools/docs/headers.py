"""Reading the comment at the head of a script as prose, commands and lists."""
import re

from tools.base.command import ROOT

# What is code within a sentence of a header: a command, the name of a file, an option with its value.
CODE = re.compile(
    r"(?P<command>python -m tools\.[\w.]+"
        r"(?: (?:RUN\b|--?[a-z][\w-]*(?:(?: -?\d[\d.]*\w*)+| [\w.]+\.mesh| [xyz]=\d[\d.]*"
        r"| (?:alternating|named|chains)\b)?|[a-z]+_[a-z]+"
        r"|(?:own|step|box|suspension|heap|cylinder)\b))*"
        r"|make validate\s+CASE=\w+|make run\b)"
    r"|(?P<file>(?<![\w/])(?:[\w.]+/)*\w[\w.]*\.(?:edp|idp|py|csv|mesh|geo|json|vtu|pvd|md)\b)"
    r"|(?P<option>(?<![\w-])--?[a-z][\w-]+(?: -?\d(?:[\w.]*\w)?(?:(?<=\de)-\d+)?"
        r"| (?:k-epsilon|kato-launder|laminar|published|all|accelerated|body|face)\b)?)")


def header(path):
    """The lines of the comment that a script begins with, without the slashes."""
    lines = []
    for line in (ROOT / path).read_text().splitlines():
        if not line.startswith("//"):
            break
        lines.append(line[2:].rstrip())
    return lines


def is_sentence(line):
    """Whether an indented line goes on with the sentence before it; commands and formulas do not."""
    return bool(re.match(r" {3}[A-Za-z(]", line)) and " " in line.strip() and " = " not in line and (line.endswith(".")
        or not re.search(r"FreeFem\+\+|python -m", line))


def blocks(lines):
    """The header as a list of (kind, text): "prose" (a paragraph on one line) and "lines" (indented lines, as they are)."""
    found = []
    for line in lines:
        after = found[-1][0] if found else ""
        kind = "gap" if not line.strip() else "lines" if line.startswith("   ") else "prose"
        if kind == "lines" and after == "prose" and is_sentence(line):
            kind = "prose"
        text = line.strip() if kind == "prose" else line[3:]
        if kind == after == "prose" and re.match(" -[a-z]", line) and found[-1][1][-1] in ".:":
            found.append((kind, text))  # an option that begins a line begins a paragraph
        elif after == kind:
            found[-1] = (kind, found[-1][1] + (" " if kind == "prose" else "\n") + text)
        else:
            found.append((kind, text))
    return [(kind, text) for kind, text in found if kind != "gap"]


def plain(text):
    """Text in which Markdown finds no marks of its own."""
    return re.sub(r"([*_$|<\[\]])", r"\\\1", text)


def prose(text):
    """A paragraph of a header as Markdown: commands, names of files and options as code."""
    parts, end = [], 0
    for found in CODE.finditer(text):
        parts += [plain(text[end:found.start()]), f"`{found.group()}`"]
        end = found.end()
    return "".join(parts) + plain(text[end:])
