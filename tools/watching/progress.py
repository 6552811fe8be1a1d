"""How far a run is, from run.json and from a table that grows.

    progress = Progress("results/pipe_obstacles/run_001")
    seen = progress.look()      # reads what is new
    seen.status, seen.time, seen.left, progress.rows["contacts"]

A look reads only the lines that have been added since the last one. A line without its end is
left for the next look.
"""
import json
import socket
import time
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from tools.base.command import BadInput
from tools.base.run_folder import RunFolder

TABLES = ("fluid", "motion", "steps")  # one of them grows while a run in time goes on
QUIET = 60.0  # s: a run whose process is gone and whose files have not changed for so long has ended
MEMORY = 60.0  # s: the speed is that of the looks of so long, where there are any
ENDED = "ended without a word (its process is gone)"


class Growing:
    """A CSV table that another process writes: {column: [values]} of the lines that are whole."""

    def __init__(self, path):
        self.path = Path(path)
        self.start_again()

    def start_again(self):
        """Forget all rows: the file is a new one, or has been cut back."""
        self.read_to, self.names, self.rows = 0, [], {}

    def read(self):
        """Take in what is new; the number of rows. Raises BadInput where a line is no row of numbers."""
        size = self.path.stat().st_size
        if size < self.read_to:
            self.start_again()
        if size > self.read_to:
            with open(self.path, "rb") as stream:
                stream.seek(self.read_to)
                new = stream.read()
            new = new[:new.rfind(b"\n") + 1]
            self.read_to += len(new)
            for line in new.decode("utf-8", "replace").splitlines():
                self.take(line)
        return len(self.rows.get("t", ()))

    def take(self, line):
        """One line: the header, else a row."""
        words = [word.strip() for word in line.split(",")]
        if not self.names:
            if "t" not in words:
                raise BadInput(f"{self.path} has no column t")
            self.names, self.rows = words, {name: [] for name in words}
            return
        try:
            values = [float(word) for word in words]
        except ValueError:
            values = []
        if len(values) != len(self.names):
            raise BadInput(f"{self.path}: '{line[:60]}' is no row of {len(self.names)} numbers")
        for name, value in zip(self.names, values):
            self.rows[name].append(value)


@dataclass
class Seen:
    """One look at a run; what is not known is None. Times of the run in its own unit, all others in seconds of the wall clock."""

    status: str  # of run.json, or ENDED
    over: bool  # the run has ended
    time: float | None  # of the last row
    end: float | None  # -tend
    step: int | None
    since: float | None  # that the run began
    quiet: float | None  # that the last row was written
    steps_per_second: float | None
    left: float | None  # until -tend at the speed of now

    @property
    def share(self):
        """The part of the run that is done, 0 to 1; None where that is not known."""
        if self.status == "finished":
            return 1.0
        return None if self.time is None or not self.end else min(1.0, max(0.0, self.time / self.end))


class Progress:
    """A run folder, looked at again and again."""

    def __init__(self, folder):
        self.folder = Path(folder)
        run = RunFolder(folder)  # raises BadInput where there is no run
        if not (self.folder / "run.json").is_file():
            raise BadInput(f"{folder} has no run.json, which says how far the run is to go; nothing can be watched")
        self.name, self.unit = run.case, run.units["time"]
        self.table, self.marks = None, []  # (wall time of a row, its t, its step)

    @property
    def rows(self):
        """{column: values} of the table that grows, empty before there is one."""
        return self.table.rows if self.table else {}

    def info(self):
        """run.json as it is now. Raises BadInput where there is none for a second."""
        problem = None
        for _ in range(20):
            try:
                return json.loads((self.folder / "run.json").read_text(encoding="utf-8"))
            except (FileNotFoundError, ValueError) as found:  # written anew at this moment
                problem = found
                time.sleep(0.05)
        raise BadInput(f"cannot read {self.folder / 'run.json'}: {problem}")

    def look(self, now=None):
        """A Seen. now: seconds since 1970, for tests."""
        run, now = RunFolder(self.folder), time.time() if now is None else now
        run.__dict__["info"] = info = self.info()
        parameters = info.get("parameters") or {}
        if self.table is None:
            there = [name for name in TABLES if (self.folder / f"{name}.csv").is_file()]
            self.table = Growing(self.folder / f"{there[0]}.csv") if there else None
        number, written = 0, None
        if self.table is not None and self.table.path.is_file():
            number, written = self.table.read(), self.table.path.stat().st_mtime
        last = {name: values[-1] for name, values in self.rows.items()} if number else {}
        status, over = run.status or "unknown", run.status != "running"
        changed = max(written or 0, (self.folder / "run.json").stat().st_mtime)
        if over and "wall_s" in info and moment(info.get("written")):  # a copy of the folder has other times
            changed = moment(info["written"])
            written = None if written is None else min(written, changed)
        here = info.get("host") in (None, socket.gethostname())  # the processes of another machine cannot be seen
        if not over and here and not run.alive and now - changed > QUIET:
            status, over = ENDED, True
        begun, until = moment(info.get("start")), changed if over else now
        seen = Seen(status, over, last.get("t"), run.parameter("-tend", 0) or None, int(last["step"]) if "step" in last else None,
            None if begun is None else max(0.0, until - begun), None if written is None else max(0.0, now - written), None, None)
        if number:
            self.judge(seen, written, None if parameters.get("-restart") else begun)
        return seen

    def judge(self, seen, written, begun):
        """The speed and the time left: from the looks of the last minute, else from the beginning of the run (begun, None if it
        continues another one). written: when the last row was."""
        if not self.marks or self.marks[-1][1] != seen.time:
            if self.marks and seen.time < self.marks[-1][1]:
                self.marks = []
            self.marks.append((written, seen.time, seen.step or 0))
            while len(self.marks) > 2 and written - self.marks[1][0] > MEMORY:
                self.marks.pop(0)
        first = self.marks[0]
        if seen.over or written - first[0] < 1:
            if begun is None:
                return
            first = (begun, 0.0, 0)
        taken = max(written - first[0], 1e-3)
        if seen.step is not None:
            seen.steps_per_second = (seen.step - first[2]) / taken
        rate = (seen.time - first[1]) / taken
        if seen.end and rate > 0 and not seen.over:
            seen.left = max(0.0, (seen.end - seen.time) / rate - (seen.quiet or 0.0))


def moment(text):
    """Seconds since 1970 of a time as run.json has it; None where it is none."""
    try:
        return datetime.fromisoformat(str(text).replace("Z", "+00:00")).timestamp()
    except ValueError:
        return None
