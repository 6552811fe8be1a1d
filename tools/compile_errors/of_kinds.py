"""Mistakes of kinds: arguments of functions and macros, values of declarations, names of another kind than the driver needs.

Each step returns a sentence, or None.
"""

from tools.compile_errors import lexer, message, project
from tools.compile_errors.case import at, article, counted, example, nearest_line, needed, parameters_of
from tools.compile_errors.names import arguments

TOLD = {
    "int": message.WHOLE,
    "real": message.REAL,
    "string": message.TEXT,
    "bool": message.TRUTH,
    "int[int]": "an int[int]",
    "real[int]": "a real[int]",
    "string[int]": "a string[int]",
    "real[int, int]": "a real[int, int]",
}
NUMBERS = (message.WHOLE, message.REAL, message.TRUTH)


def macro_parameters(case, said):
    """A macro or function of the case with other parameters than its driver gives it."""
    expected = {name: found[0][1] for name, found in case.examples.items()}
    for file, one in case.globals():
        there = expected.get(one.name)
        if one.kind == "macro":
            wanted = (
                project.hooks().get(one.name)
                if one.name in project.hooks()
                else there.parameters if there and there.kind == "macro" else None
            )
            if wanted is not None and len(wanted) != len(one.parameters or ()):
                return at(
                    file,
                    one.line,
                    f"the macro {one.name} is written {one.name}({', '.join(one.parameters or ())}) here; the driver calls"
                    f" {one.name}({', '.join(wanted)})",
                )
        elif (
            there
            and there.kind == one.kind
            and there.parameters is not None
            and one.parameters is not None
            and len(one.parameters) != len(there.parameters)
            and needed(case, one.name)
        ):
            return at(
                file,
                one.line,
                f"the function {one.name} takes {counted(one.parameters)} here; the driver calls it as {there.text}"
                f" ({example(case, one.name)})",
            )


def macro_call(case, said):
    """A macro that is called with another number of arguments than it has."""
    if said.kind != "macro arguments":
        return None
    for file in case.files:
        for tokens in file.script.lists():
            for place, token in enumerate(tokens[:-1]):
                if token.text == said.name and token.line >= 1:
                    macro = next((macro for other in case.files for macro in other.script.macros if macro.name == said.name), None)
                    takes = (
                        macro.parameters
                        if macro
                        else next((one.parameters for _, one in project.offered().get(said.name, []) if one.kind == "macro"), None)
                    )
                    given = arguments(tokens, place + 1)[0] if tokens[place + 1].text == "(" else []
                    if takes is not None and len(takes) != len(given):
                        return at(
                            file,
                            token.line,
                            f"the macro {said.name} takes {counted(takes)} ({', '.join(takes)}), but is given {len(given)}",
                        )


def call(case, said):
    """A call with other arguments than its function takes."""
    file = case.own(said)
    if said.kind != "operator" or said.name != "(" or not file:
        return None
    best = None
    for tokens in file.script.lists():
        for place, token in enumerate(tokens[:-1]):
            if token.kind != "name" or tokens[place + 1].text != "(":
                continue
            given, end = arguments(tokens, place + 1)
            if token.line <= said.line <= (tokens[end].line if end < len(tokens) else token.line) and len(given) == len(said.given):
                takes = parameters_of(case, token.text)
                fits = takes is not None and any(len(takes) == len(choice) for choice in said.choices)
                if fits and (best is None or token.line == said.line):
                    best = best if best and best[3] and not fits else (token, given, takes, fits)
    if not best:
        return None
    token, given, takes, _ = best
    if len(takes) != len(given):
        return at(file, token.line, f"{token.text} takes {counted(takes)} ({', '.join(takes)}), but is given {len(given)}")
    for number, (parameter, got) in enumerate(zip(takes, said.given)):
        wanted = TOLD.get(parameter.rsplit(" ", 1)[0].removesuffix(" &"))
        if (
            wanted
            and got != wanted
            and not (wanted in NUMBERS and got in NUMBERS and not (wanted == message.WHOLE and got == message.REAL))
        ):
            return at(
                file,
                token.line,
                f"argument {number + 1} of {token.text} ({parameter}) must be {wanted}, but is {got}:"
                f" {lexer.shown(' '.join(one.text for one in given[number]), 40)}",
            )
    return at(file, token.line, f"{token.text} takes ({', '.join(takes)}), but is given {', '.join(said.given)}")


def kinds(case, said):
    """A name of the case of another kind than the driver needs."""
    if case.own(said) or said.kind in ("unknown", "file", "load"):
        return None
    words = case.library_words(said)
    suspects = []
    for file, one in case.globals():
        found = case.examples.get(one.name, [])
        usual = {other.kind for _, other in found}
        if found and one.kind not in usual and needed(case, one.name) and not ({one.kind} | usual <= {"int", "real"}):
            suspects.append((one.name not in words, file, one))
    if suspects:
        _, file, one = min(suspects, key=lambda other: other[0])
        there = case.examples[one.name][0][1]
        return at(
            file,
            one.line,
            f"{one.name} is {article(one.kind)} here, but {case.needs()} needs {article(there.kind)}: {example(case, one.name)}",
        )
    names = [one.name for _, one in case.globals()]
    twice = next((one for one in case.globals() if names.count(one[1].name) > 1), None)
    if twice:
        both = [other.line for _, other in case.globals() if other.name == twice[1].name]
        return at(twice[0], both[-1], f"{twice[1].name} is declared a second time here; the first is in line {both[0]}")


def assignment(case, said):
    """A value that a declaration cannot take."""
    file = case.own(said)
    if said.kind != "operator" or said.name not in ("<-", "=") or not file or len(said.given) != 2:
        return None
    fitting = [one for one in file.declared + file.inner if one.line == said.line and TOLD.get(one.kind) == said.given[0]]
    if said.given[1] == message.TEXT:
        fitting = [one for one in fitting if '"' in one.text] or fitting
    if fitting:
        one = fitting[-1 if said.token == ";" else 0]
        return at(
            file,
            one.line,
            f"{one.name} is {said.given[0]} ({one.kind}) and cannot be set to {said.given[1]}: {lexer.shown(one.text, 60)}",
        )


def operator(case, said):
    """What no operator takes, no kind has."""
    file = case.own(said)
    if file and said.kind == "operator" and len(said.given) == 2 and said.name not in ("(", "<-"):
        return at(file, said.line, f"{said.name} does not take {said.given[0]} and {said.given[1]}")
    if file and said.kind == "member":
        return at(file, nearest_line(file, said.name, said.line), f".{said.name} does not exist for what stands before it")


def no_function(case, said):
    """A variable that is called as a function."""
    file = case.own(said)
    if said.kind != "no function" or not file:
        return None
    for tokens in file.script.lists():
        for token, after in zip(tokens, tokens[1:]):
            if token.line == said.line and token.kind == "name" and after.text == said.name:
                one = next(
                    (
                        one
                        for _, one in case.globals()
                        if one.name == token.text and one.kind != "macro" and not one.kind.startswith("func")
                    ),
                    None,
                )
                if one:
                    return at(
                        file, token.line, f"{token.text} is a {one.kind} (line {one.line}), which cannot be called as a function"
                    )
