"""The runs of a sweep: what varies, all combinations, the folder of each."""
import hashlib
import itertools
import math
import re
from dataclasses import dataclass, field
from pathlib import Path

from tools.base.command import ROOT, BadInput

MOST = 100_000  # runs
NAME = re.compile(r"[A-Za-z][\w-]*")
RANGE = re.compile(r"([^:]+):([^:]+?)(?::([^:]+))?")


@dataclass
class Sweep:
    """What to run. vary: {parameter without its dash: texts of values}; quantities: names or expressions; over: parameters that
    means are taken over; options: {"-dt": "0.1"} of every run; own: files of quantities."""
    script: str
    vary: dict
    quantities: list
    over: list = field(default_factory=list)
    options: dict = field(default_factory=dict)
    out: Path = None
    jobs: int = 1
    limit: float = None
    retry: bool = False
    own: list = field(default_factory=list)

    @property
    def case(self):
        """The case's name."""
        return Path(self.script).stem

    @property
    def points(self):
        """[{parameter: text}] of all runs, the last parameter varying fastest."""
        return [dict(zip(self.vary, values)) for values in itertools.product(*self.vary.values())]


def numbers_of(text, low, high, step):
    """The texts of a range such as 1:20 or 0.1:0.5:0.1, both ends included."""
    try:
        first, last, by = float(low), float(high), float(step or 1)
        if not all(map(math.isfinite, (first, last, by))) or by <= 0 or last < first:
            raise ValueError
    except ValueError:
        raise BadInput(f"'{text}' is no range FIRST:LAST or FIRST:LAST:STEP with a step above 0") from None
    if (last - first) / by > MOST:
        raise BadInput(f"'{text}' has more than {MOST} values")
    steps = round((last - first) / by)
    if abs(first + steps * by - last) > 1e-9 * max(by, abs(last)):
        raise BadInput(f"'{text}' does not reach {high} in steps of {by:g}; give FIRST:LAST:STEP with a step that does")
    return [f"{first + k * by:.12g}" for k in range(steps + 1)]


def read_vary(words, folder):
    """{parameter: texts} of words such as reynolds=100,200 and seed=1:20. Values that are files in `folder`, where the user is,
    become whole paths. Raises BadInput."""
    found = {}
    for word in words:
        name, sign, values = word.partition("=")
        name = name.strip().removeprefix("-")
        if not sign or not NAME.fullmatch(name):
            raise BadInput(f"'{word}' after --vary must be PARAMETER=VALUE,VALUE,... or PARAMETER=FIRST:LAST")
        if name in found:
            raise BadInput(f"--vary names {name} twice")
        texts = []
        for text in map(str.strip, values.split(",")):
            span = RANGE.fullmatch(text)
            if span:
                texts += numbers_of(text, *span.groups())
            elif text == "":
                raise BadInput(f"'{word}' has an empty value")
            else:
                path = folder / text
                texts.append(str(path.resolve()) if folder != ROOT and path.is_file() and isinstance(value_of(text), str) else text)
        if len({value_of(text) for text in texts}) < len(texts):
            raise BadInput(f"'{word}' names one value twice")
        found[name] = texts
    if math.prod(map(len, found.values())) > MOST:
        raise BadInput(f"the sweep has more than {MOST} runs")
    return found


def value_of(text):
    """The number that a text is, else the text."""
    try:
        return float(text)
    except ValueError:
        return text


def folder_name(point):
    """The name of a run's folder: reynolds=100,seed=1; a short hash where a value has other signs or the name is long."""
    name = ",".join(f"{key}={value}" for key, value in point.items()) or "default"
    plain = re.sub(r"[^A-Za-z0-9._+=,@%-]", "_", name)
    if plain == name and len(name) <= 120:
        return name
    return f"{plain[:100]}_{hashlib.sha256(name.encode()).hexdigest()[:8]}"


def words_of(point):
    """The values of a run in words."""
    return ", ".join(f"{name} {value}" for name, value in point.items()) or "the case as it is"
