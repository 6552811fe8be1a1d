"""Runs of cases side by side, of which those are kept that stand finished in their folders.

    jobs = [Job("cases/settling_disk.edp", {"-dt": dt}, out / "runs" / f"dt{dt}") for dt in (0.002, 0.001)]
    records = run_all(jobs, 2, ended=lambda job, record: print(record["reason"] or "finished"))

Beside the folder NAME of a run stand NAME.json, its record once it has ended, NAME.log, what it printed, and NAME.begun while it
is under way. A run is kept as long as nothing that it depends on has changed (tools.base.runner.fingerprint). What was cut off, by
a signal or with this program, has no record: it is run again, or with go_on continued from its last checkpoint.

A record is a dict: key (the fingerprint), status, reason (one line, empty for a good end), cpu_s, wall_s, memory_mib (of the last
process of the run), repeats, timing, commit, run (the folder), fresh (False where it was kept).
"""
import concurrent.futures
import fcntl
import json
import math
import os
import statistics
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from tools.base.command import BadInput
from tools.base.runner import commit, fingerprint, freefem, option_words, run_case, run_command, side_by_side
from tools.base.tables import write_text

AT_LIMIT = 124  # status of a run that was stopped at its limit
FINISHED = ("", "finished")  # statuses in run.json of a run that is at its end


@dataclass
class Job:
    """One run. options: {"-dt": 0.001}; folder: its run folder; limit: most wall-clock seconds; repeats: how often it runs, the
    median time counts; timing: nothing else runs meanwhile; retry: run again what failed; go_on: continue what was cut off."""
    script: str
    options: dict
    folder: Path
    limit: float = None
    repeats: int = 1
    timing: bool = False
    retry: bool = False
    go_on: bool = False
    key: str = field(default="", init=False)

    def beside(self, ending):
        """The file of this ending beside the run folder."""
        return self.folder.with_name(f"{self.folder.name}.{ending}")


def said_of(folder):
    """What run.json says of the end of a run; empty where there is none, or nothing in it."""
    try:
        return str(json.loads((folder / "run.json").read_text()).get("status") or "")
    except (OSError, ValueError, AttributeError):
        return ""


def read_note(job):
    """The record beside the folder, empty where there is none."""
    try:
        found = json.loads(job.beside("json").read_text())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def kept(job):
    """The record of a run that need not run again, None where it must."""
    job.key = job.key or fingerprint(job.script, job.options)
    old = read_note(job)
    status = old.get("status")
    if old.get("key") != job.key or old.get("repeats", 0) < job.repeats or (job.timing and not old.get("timing")):
        return None
    if status == 0:
        good = job.folder.is_dir() and said_of(job.folder) in FINISHED
    else:
        good = not job.retry and not (job.go_on and isinstance(status, int) and status < 0)  # below 0: a signal
    return {**old, "fresh": False} if good else None


def can_go_on(job):
    """Whether a run of the same fingerprint was cut off in the folder behind a checkpoint."""
    if not job.go_on or not any(job.folder.glob("restart_*.sha")):
        return False
    try:
        begun = job.beside("begun").read_text()
    except OSError:
        begun = ""
    old = read_note(job)
    status = old.get("status")
    return begun == job.key or old.get("key") == job.key and isinstance(status, int) and (status <= 0 or status == AT_LIMIT)


def attempt(job, going):
    """Run once: from the last checkpoint where going, and that is whole, else from the beginning. Returns a Done."""
    if going:
        done = run_command([freefem(), "-nw", str(job.script), *option_words(job.options), "-restart", str(job.folder)], job.limit)
        if done.status != 3:
            return done
    return run_case(job.script, job.options, out=job.folder, limit=job.limit)


def run_job(job):
    """The record of a run: the one that is there, or of a run that is made now."""
    old = kept(job)
    if old:
        return old
    record = {"run": str(job.folder), "timing": job.timing, "commit": commit(), "fresh": True}
    going, runs = can_go_on(job), []
    job.folder.parent.mkdir(parents=True, exist_ok=True)
    job.beside("begun").write_text(job.key)
    job.beside("json").unlink(missing_ok=True)
    for _ in range(job.repeats):
        runs.append(attempt(job, going and not runs))
        if not runs[-1].ok:
            break
    last = runs[-1]
    status, reason = last.status, last.reason
    if status == 0 and said_of(job.folder) not in FINISHED and job.go_on:
        reason = f"not at its end: {said_of(job.folder)}"
    record.update(key=job.key, repeats=job.repeats, status=status, reason=reason,
                  cpu_s=statistics.median(r.cpu_s for r in runs), wall_s=statistics.median(r.wall_s for r in runs),
                  memory_mib=max(r.memory_mb for r in runs))
    job.beside("log").write_text(last.log)
    write_text(job.beside("json"), json.dumps(record, indent=1))
    job.beside("begun").unlink(missing_ok=True)
    return record


def failure(folder, reason, status=3, **more):
    """The record of a run that could not begin."""
    return {"run": str(folder), "commit": commit(), "fresh": True, "status": status, "reason": reason, "cpu_s": math.nan,
        "wall_s": math.nan, "memory_mib": math.nan, "timing": False, **more}


@contextmanager
def claimed(folders):
    """Holds the folders for this process. Raises BadInput where another one has one of them; a file system without locks has
    none."""
    with ExitStack() as held:
        for folder in sorted(folders):
            folder.mkdir(parents=True, exist_ok=True)
            number = os.open(folder, os.O_RDONLY)
            held.callback(os.close, number)
            try:
                fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise BadInput(f"another sweep or study makes runs in {folder}; wait until it ends, or give another "
                    "--out") from None
            except OSError:
                pass
        yield


def run_all(jobs, workers, ended=None):
    """The records of jobs in their order, of `workers` runs at a time. ended(job, record): called in this thread as each of them
    ends; what it raises ends all."""
    freefem()
    with claimed({job.folder.parent for job in jobs}), side_by_side(workers) as pool:
        waiting = {pool.submit(run_job, job): k for k, job in enumerate(jobs)}
        records = [None] * len(waiting)
        for future in concurrent.futures.as_completed(waiting):
            k = waiting[future]
            records[k] = future.result()
            if ended:
                ended(jobs[k], records[k])
    return records
