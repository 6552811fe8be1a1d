"""The sentence: FreeFEM's message and the text of the case together.

Each step looks for one kind of mistake and returns a sentence, or None. The first that finds something counts.
"""

import re
from pathlib import Path

from tools.compile_errors import lexer, message, project
from tools.compile_errors.case import Case, Own, at, hint
from tools.compile_errors.names import FORBIDDEN, TYPES, arguments, spelled
from tools.compile_errors.of_kinds import assignment, call, kinds, macro_call, macro_parameters, no_function, operator
from tools.compile_errors.of_names import FOREIGN, hidden_words, hides, replaced_everywhere, taken, unknown

OPERANDS = ("name", "number", "string")


def sentence(path, shown, output):
    """Why the script at `path`, which the sentence calls `shown`, does not compile, by FreeFEM's output."""
    case, said = Case(path, shown), message.read(output)
    for step in STEPS:
        if found := step(case, said):
            return found
    return last_resort(case, said)


def before_run(path, shown):
    """What is wrong with a case that compiles, as a sentence; None where nothing is. It computes something else than it says."""
    own = Own(Path(path), shown)
    for macro in own.script.macros:
        if fault := next((fault for fault in own.script.faults if lexer.swallows(macro) and fault.line == macro.line), None):
            return at(own, fault.line, fault.text)
    for one in own.declared:
        if one.depth == 0 and one.name in FORBIDDEN:
            return at(own, one.line, hides(one))
        value = re.fullmatch(r"int\[int\] \w+ = (label[A-Z]\w*)", one.text)
        if value:
            return at(
                own,
                one.line,
                f"{one.name} is set to {value.group(1)}, a single number; a list of labels stands in brackets: [{value.group(1)}]",
            )
    return None


def amiss(case, said):
    """Brackets, quotes, comments, ends of macros."""
    for file in case.files:
        for fault in file.script.faults:
            return at(file, fault.line, fault.text)


def function_heads(case, said):
    """A function without func, without the kind of its value, or with a parameter without its kind."""
    for file in case.files:
        tokens = file.script.tokens
        kinds = TYPES.union(project.spaces())
        for place in range(1, len(tokens) - 1):
            name = tokens[place]
            if name.kind != "name" or tokens[place + 1].text != "(" or name.text in kinds:
                continue
            inner, end = arguments(tokens, place + 1)
            body = end + 1 < len(tokens) and tokens[end + 1].text == "{"
            if not body or name.text in ("for", "if", "while"):
                continue
            if tokens[place - 1].text == "func":
                return at(file, name.line, f"the function {name.text} lacks the kind of its value: func real {name.text}(...)")
            bare = next((one for one in inner if one and one[0].text not in kinds), None)
            if tokens[place - 1].text in kinds | {"]"} and bare:
                return at(
                    file, name.line, f"the parameter {spelled(bare)} of {name.text} lacks its kind, as in real {spelled(bare)}"
                )
            if tokens[place - 1].text in kinds and tokens[place - 2].text != "func":
                return at(
                    file,
                    name.line,
                    f"{name.text} is to be a function, which begins with func: func {tokens[place - 1].text} {name.text}(...)",
                )


def missing_file(case, said):
    """An include or a plug-in that is not there."""
    if said.kind not in ("file", "load"):
        return None
    what = "include" if said.kind == "file" else "load"
    for file in case.files:
        for token, after in zip(file.script.tokens, file.script.tokens[1:]):
            if token.text == what and after.text == f'"{said.name}"':
                if what == "load":
                    known = {
                        name for path in project.library() for name in re.findall(r'^load "(\w+)"', project.text_of(path), re.M)
                    }
                    return at(file, token.line, f"FreeFEM has no plug-in {said.name}" + hint(said.name, known))
                known = [*project.drivers(), *(path for path in project.library() if path.startswith("lib/"))]
                ends = {path.rsplit("/", 1)[-1]: path for path in known}
                near = project.nearest(said.name, known) or ends.get(project.nearest(said.name, ends, 0.2) or said.name)
                return at(file, token.line, f"there is no file {said.name}" + (f"; is {near} meant?" if near else ""))


def macro_endings(case, said):
    """A macro of statements without its last semicolon, a macro of a value with one."""
    for file in case.files:
        for macro in file.script.macros:
            usual = project.endings(macro.name, case.driver) - {""}
            if not macro.body or not usual:
                continue
            last = macro.body[-1]
            if usual <= {";", "}"} and last.text not in (";", "}"):
                return at(file, last.line, f"the macro {macro.name} has no ; after its last statement, behind {last.text}")
            if not usual & {";", "}"} and last.text == ";":
                return at(
                    file, last.line, f"the macro {macro.name} stands for a value and has a ; at its end, which it must not have"
                )


def syntax(case, said):
    """Something is missing between two words, or one is too many."""
    file, rest = case.own(said), case.main.script.tokens
    if said.kind == "syntax" and said.file == "-- unknown --" and rest and rest[-1].text not in (";", "}"):
        return at(
            case.main, rest[-1].line, f"a ; is missing at the end of this line, behind {rest[-1].text}, where the script ends"
        )
    if said.kind != "syntax" or not file:
        return None
    pairs = [
        (tokens[place - 1], token, tokens[place - 2] if place > 1 else tokens[0])
        for tokens in file.script.lists()
        for place, token in enumerate(tokens)
        if place and token.line == said.line and token.text.strip('"') == said.token.strip('"')
    ]
    if not pairs:
        return None
    before, token, earlier = max(pairs, key=lambda pair: strange(*pair))
    foreign = next((word for word in (token.text, before.text + token.text) if word in FOREIGN), None)
    if foreign:
        return at(file, token.line, f"{foreign} is none of FreeFEM's signs and words; it has {FOREIGN[foreign]}")
    if before.text in ("include", "load"):
        return at(file, before.line, f"the name behind {before.text} stands in double quotes")
    begins = token.kind in OPERANDS or token.text in ("{", "(")
    if ends(before) and (begins or token.text == "}") and before.line < token.line:
        return at(file, before.line, f"a ; is missing at the end of this line, behind {before.text}")
    if ends(before) and token.text == "}":
        return at(file, token.line, f"a ; is missing before }}, behind {before.text}")
    if token.kind == "number" and before.text == "," and earlier.kind == "number":
        return at(file, token.line, f"{earlier.text},{token.text} is no number: decimals stand behind a point")
    if ends(before) and begins:
        return at(file, token.line, f"something is missing between {before.text} and {token.text}: a comma, an operator or a ;")
    if before.text == "=" and token.text == "{":
        return at(file, token.line, f"a list stands in brackets [...], not in braces: {earlier.text} = [...]")
    return at(file, token.line,
        f"{token.text} cannot stand here, behind {spelled([earlier, before]) if before.text in '=,' else before.text}")


def strange(before, token, earlier):
    """How little a token fits behind another."""
    if before.text == "," and token.kind == earlier.kind == "number" or ends(before) and token.kind in OPERANDS:
        return 3
    if token.kind == "sign" and token.text not in "([{-!;}" and not ends(before):
        return 2
    return 0 if before.text in TYPES else 1


def ends(token):
    """Whether a token can be the last of a value."""
    return token.kind in OPERANDS or token.text in (")", "]", "++", "--")


def last_resort(case, said):
    """FreeFEM's own words, with the line of the case where there is one."""
    file, words = case.own(said), said.said or "FreeFEM gives no reason"
    near = f", before {said.token}" if said.token else ""
    if file:
        return at(file, said.line, f"FreeFEM stops here{near}: {words}")
    return f"{case.main.shown} does not compile: FreeFEM stops in {said.file or 'it'} line {said.line}{near}: {words}"


COMPILE = ("-ne", "-v", "1", "-jc")  # FreeFEM's options: read the script, say what its declarations hide, run nothing
STEPS = (
    amiss,
    function_heads,
    missing_file,
    macro_parameters,
    replaced_everywhere,
    unknown,
    taken,
    hidden_words,
    call,
    assignment,
    no_function,
    operator,
    macro_call,
    macro_endings,
    syntax,
    kinds,
)
