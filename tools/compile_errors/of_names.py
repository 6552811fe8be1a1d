"""Mistakes of names: missing, misspelt, taken, too early, hiding a word of the language, replaced by a macro.

Each step returns a sentence, or None.
"""

from tools.compile_errors import project
from tools.compile_errors.case import at, article, example, nearest_line, needed, parameters_of
from tools.compile_errors.names import FORBIDDEN, arguments

FOREIGN = {
    "and": "&&",
    "or": "||",
    "not": "!",
    "elif": "else if",
    "elseif": "else if",
    "**": "^ for powers",
    "#": "// for comments",
    "float": "real",
    "integer": "int",
    "str": "string",
    "import": "include",
    "from": "include",
    "double": "real",
    "boolean": "bool",
    "def": "func",
    "function": "func",
    "print": "cout << ... << endl",
    "printf": "cout << ... << endl",
    "const": "no constants",
    "True": "true or 1",
    "False": "false or 0",
    "null": "no such value",
    "None": "no such value",
    "then": "if (...) ...",
    "do": "for and while",
    "var": "real, int, string and more",
    "auto": "real, int, string and more",
}  # what other languages have


def unknown(case, said):
    """A name that does not exist: missing, misspelt, or used before it is there."""
    if said.kind != "unknown":
        return None
    file, name = case.own(said), said.name
    if not file:
        return lacking(case, name)
    if needed(case, name) and (misspelt := stranger(case, name)):
        return misspelt
    line = nearest_line(file, name, said.line)
    known = [one for one in case.globals() if one[1].name == name]
    if text := unquoted(case, file, name, line):
        return text
    if known and known[0][1].line >= line or known and known[0][0] is not file:
        return at(
            file,
            line,
            f"{name} is used here before it is declared, in line {known[0][1].line}"
            + ("" if known[0][0] is file else f" of {known[0][0].shown}"),
        )
    inner = next((one for one in file.declared + file.inner if one.name == name), None)
    macro = next((macro for macro in file.script.macros if macro.line <= line <= macro.last), None)
    if macro and macro.name in case.examples and name in (case.examples[macro.name][0][1].parameters or ()):
        return at(file, line, f"{name} is no parameter of the macro {macro.name}: write {case.examples[macro.name][0][1].text}")
    if sentence := not_yet_included(case, file, name, line, macro):
        return sentence
    if inner and inner.line != line:
        return at(
            file,
            line,
            f"{name} does not exist here: it is declared in line {inner.line}, within braces or parentheses that are closed before",
        )
    local = {one.name: one.line for one in file.declared + file.inner}
    counts = [token.text for tokens in file.script.lists() for token in tokens]
    choices = {one.name for _, one in case.globals()} | set(local) | set(project.offered()) | set(case.examples)
    near = project.nearest(name, choices, preferred={one for one in local if counts.count(one) < 2})
    near = near or project.nearest(name, set().union(*map(project.words_of, case.reached)) if case.reached else ())
    if name in FOREIGN:
        return at(file, line, f"{name} is no word of FreeFEM's language; it has {FOREIGN[name]}")
    if needed(case, name):
        return at(file, line, f"{name} does not exist; {case.needs()} needs it too: {example(case, name)}")
    where = f" (line {local[near]})" if near in local else ""
    return at(
        file,
        line,
        f"{name} does not exist" + (f"; is {near}{where} meant?" if near else ": declare it before, or correct the name"),
    )


def not_yet_included(case, file, name, line, macro):
    """A name of the project whose file is not included, or only behind the line; None of other names."""
    offered = project.offered().get(name)
    if not offered:
        return None
    path = next((path for path, _ in offered if path in case.reached), offered[0][0])
    brought = [number for number, after in file.includes() if after in case.project and path in project.reached_from((after,))]
    common = path in project.reached_from((project.COMMON,))
    if common and project.COMMON not in case.project:
        return at(
            file,
            line,
            f"{name} is declared in {path}, which is not included before: a case begins with include \"{project.COMMON}\"",
        )
    if path in case.reached:
        if brought and brought[0] >= line and not macro:
            return at(
                file,
                line,
                f"{name} is used here before it is declared, by {path}, which the include of line {brought[0]} brings; what"
                " uses it stands behind that line, or in a macro such as caseStep",
            )
    elif not needed(case, name):
        return at(file, line, f"{name} is declared in {path}, which is not included: include \"{path}\" before")
    return None


def unquoted(case, file, name, line):
    """A text without its quotes, where a function takes a text."""
    for tokens in file.script.lists():
        for place, token in enumerate(tokens[:-1]):
            takes = parameters_of(case, token.text) if token.kind == "name" and tokens[place + 1].text == "(" else None
            for parameter, given in zip(takes or (), arguments(tokens, place + 1)[0] if takes else ()):
                if parameter.startswith("string ") and any(one.text == name and one.line == line for one in given):
                    return at(
                        file,
                        line,
                        f"{name} does not exist; a text ({parameter} of {token.text}) stands in double quotes:"
                        f" \"{''.join(one.text for one in given)}\"",
                    )


def stranger(case, name):
    """A name that the case declares, near to one that it lacks, and that nothing of the project knows."""
    strangers = {}
    for file, one in case.globals():
        if one.name not in case.examples and not any(one.name in project.words_of(path) for path in case.reached):
            strangers.setdefault(one.name, (file, one))
    near = project.nearest(name, strangers)
    words = [token.text for file in case.files for tokens in file.script.lists() for token in tokens]
    if near and (len(name) > 3 or near.lower() == name.lower() or near[:-1] == name or words.count(near) == 1):
        file, one = strangers[near]
        return at(file, one.line, f"{near} is no name that {case.needs()} asks for; it asks for {name}, which is missing")


def other_driver(case):
    """The driver of which a case sets all names, where it lacks several of its own; None without one."""
    own = {one.name for _, one in case.globals()}
    if case.driver and len(project.always(case.driver) - own) > 2:
        return next((driver for driver in project.drivers() if project.always(driver) and not project.always(driver) - own), None)


def lacking(case, name):
    """A name that the driver uses and the case does not declare."""
    if misspelt := stranger(case, name):
        return misspelt
    used = {token.text: 0 for file in case.files for tokens in file.script.lists() for token in tokens if token.kind == "name"}
    if name in case.examples:
        kind = case.examples[name][0][1].kind
        inner = next(((file, one) for file in case.files for one in file.declared + file.inner if one.name == name), None)
        if inner:
            return at(
                inner[0],
                inner[1].line,
                f"{name} is declared within braces here, so that {case.needs()}, which needs it, does not see it",
            )
        other = other_driver(case)
        return f"{case.main.shown}: {'the macro ' if kind == 'macro' else ''}{name} is missing, which {case.needs()} needs; " + (
            f"the case sets what {other} needs: is this driver meant?" if other else example(case, name)
        )
    if name in used:
        file, line = next(
            (file, token.line) for file in case.files for tokens in file.script.lists() for token in tokens if token.text == name
        )
        return at(file, line, f"{name} does not exist where {case.needs()} reads this macro of the case")
    return None


def taken(case, said):
    """A name that is declared twice."""
    if said.kind not in ("exists", "macro exists"):
        return None
    own = [(file, one) for file in case.files for one in file.declared + file.inner if one.name == said.name]
    outer = [one for one in own if one[1].depth == 0]
    here = case.own(said)
    if said.kind == "exists" and here:
        line = nearest_line(here, said.name, said.line)
        earlier = next((one for file, one in own if file is here and one.line < line or file is not here), None)
        twice = [one for file, one in own if file is here and one.line == line]
        if len(twice) > 1 and twice[-1].depth > 0:
            return at(
                here,
                line,
                f"{said.name} is declared twice in this line; the parts of for (int k = 0; k < n; ++k) stand between semicolons",
            )
        if earlier:
            return at(here, line, f"{said.name} is declared a second time here; the first is in line {earlier.line}")
    elif len(outer) > 1:
        return at(
            outer[-1][0], outer[-1][1].line, f"{said.name} is declared a second time here; the first is in line {outer[0][1].line}"
        )
    where = next((path for path, one in project.offered().get(said.name, []) if path in case.reached), case.library_file(said))
    if outer or own:
        file, one = (outer or own)[0]
        return at(file, one.line, f"{said.name} is a name of {where or case.needs()} already; give the case's another")


def hidden_words(case, said):
    """A name of the case that hides a word of the language, which lib/ then misses."""
    if case.own(said) and said.kind not in ("member", "no function", "operator"):
        return None
    words, here = case.library_words(said), case.own(said)
    if here:
        words = {token.text for tokens in here.script.lists() for token in tokens if token.line == said.line}
    for file, one in case.globals():
        if one.name in FORBIDDEN and (not here or one.name in words) or one.name in said.hidden and one.name in words:
            return at(file, one.line, hides(one))


def hides(one):
    """What a declaration of a word of the language does."""
    return (
        f"{one.name} is a word of FreeFEM's (as x and y, the coordinates, or N, the normal), which {article(one.kind)} of that name"
        " replaces in silence; call it otherwise"
    )


def replaced_everywhere(case, said):
    """A macro of the case whose name is a word of lib/."""
    line_words = case.library_words(said) if said.kind != "unknown" else ()
    known = set(project.hooks()) | {
        name for name, found in project.examples(None).items() if any(one.kind == "macro" for _, one in found)
    }
    suspects = [(file, macro) for file in case.files for macro in file.script.macros if macro.name not in known]
    for file, macro in suspects:
        if macro.name != said.macro and macro.name not in line_words and said.kind != "macro call":
            continue
        for path in sorted(case.reached):
            if macro.name in project.words_of(path):
                return at(
                    file,
                    macro.line,
                    f"FreeFEM replaces the name of the macro {macro.name} everywhere, in {path} line"
                    f" {project.words_of(path)[macro.name]} too; give it a name of your own (or use a variable or a func)",
                )
