"""A case that does not compile, with what the project knows of it, and the parts that the sentences share."""

from pathlib import Path

from tools.base.command import ROOT
from tools.compile_errors import lexer, project
from tools.compile_errors.names import declared, included


class Own:
    """A file of the user's: the case, or what it includes of their own. shown: its name for sentences; named: as an include names
    it."""

    def __init__(self, path, shown, named=None):
        self.path, self.shown, self.named = path, shown, named
        self.text = path.read_bytes().decode("utf-8", errors="replace")
        self.script = lexer.read(self.text)
        self.declared = declared(self.script.tokens, project.spaces()) + project.of_macros(self.script.macros)
        self.inner = [one for macro in self.script.macros for one in declared(macro.body, project.spaces())]

    def includes(self):
        """[(line, name)] of its include lines."""
        return [
            (token.line, after.text.strip('"'))
            for token, after in zip(self.script.tokens, self.script.tokens[1:])
            if token.text == "include"
        ]


class Case:
    """A case that does not compile: its own files, its driver, the project's files that it includes."""

    def __init__(self, path, shown):
        self.files, self.project = [], []
        waiting = [(Path(path), shown, None)]
        while waiting:
            file, name, named = waiting.pop(0)
            own = Own(file, name, named)
            self.files.append(own)
            for other in included(own.text):
                beside = file.parent / other
                inside = next(
                    (
                        str(there.resolve().relative_to(ROOT))
                        for there in (ROOT / other, beside)
                        if there.is_file()
                        and there.resolve().is_relative_to(ROOT)
                        and str(there.resolve().relative_to(ROOT)).startswith(("lib/", "scripts/"))
                    ),
                    None,
                )
                if inside:
                    self.project.append(inside)
                    continue
                there = next((there for there in (beside, Path.cwd() / other) if there.is_file()), None)
                if there and all(there.resolve() != one.path.resolve() for one in self.files):
                    waiting.append((there, str(Path(name).parent / other) if there is beside else other, other))
        self.main = self.files[0]
        self.drivers = [one for one in self.project if one in project.drivers()]
        self.driver = self.drivers[0] if self.drivers else None
        self.reached = project.reached_from(tuple(self.project))
        self.examples = project.examples(self.driver)

    def own(self, said):
        """The user's file that a message speaks of, None where it is none of them."""
        if not said.file and any(token.line == said.line and token.text == said.token for token in self.main.script.tokens):
            return self.main
        return next((file for file in self.files if said.file and said.file in (file.named, str(file.path))), None)

    def library_file(self, said):
        """The file of the project that a message speaks of, a path from the root."""
        place = Path(ROOT, said.file).resolve() if said.file else None
        return next((path for path in sorted(self.reached) if ROOT / path == place), None)

    def library_words(self, said):
        """The words of the line of the project that a message speaks of."""
        path = self.library_file(said)
        lists = project.script_of(path).lists() if path else ()
        return {token.text for tokens in lists for token in tokens if token.line == said.line}

    def globals(self):
        """[(file, Declared)] of what the user's files declare for all that follows."""
        return [(file, one) for file in self.files for one in file.declared if one.depth == 0]

    def needs(self):
        """How the sentence calls what needs a name."""
        return self.driver or "the driver"


def at(file, line, text):
    """A sentence on a line of a file."""
    return f"{file.shown} line {line}: {text}"


def hint(word, known):
    """What was meant, where something is near."""
    near = project.nearest(word, known)
    return f"; is {near} meant?" if near else ""


def counted(parameters):
    """How many arguments, in words."""
    return "no argument" if not parameters else f"{len(parameters)} argument{'s' if len(parameters) > 1 else ''}"


def article(kind):
    """A kind with its article."""
    return f"an {kind}" if kind[0] in "aeio" else f"a {kind}"


def needed(case, name):
    """Whether the driver, or what it includes, uses a name that it does not declare: a name that a case sets."""
    return name in case.examples and any(
        name in project.words_of(path) and name not in project.names_of(path) for path in case.reached
    )


def example(case, name):
    """How another case sets a name."""
    path, one = case.examples[name][0]
    return f"{path} has {lexer.shown(one.text, 60)} (line {one.line})"


def nearest_line(file, name, line):
    """The line nearest to this one in which the name stands."""
    return min(
        (token.line for tokens in file.script.lists() for token in tokens if token.text == name),
        key=lambda other: abs(other - line),
        default=line,
    )


def parameters_of(case, name):
    """The parameters of a function of the case or of the project, None of what is none."""
    for _, one in [(None, one) for file in case.files for one in file.declared] + project.offered().get(name, []):
        if one.name == name and one.parameters is not None and one.kind != "macro":
            return one.parameters
