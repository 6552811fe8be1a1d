"""python -m tools.mesh in processes of their own that start in a moment: each is forked from one that has imported gmsh and the
tools, which takes half a second.

As a program it reads a line for each command, the words and the files for its output, and prints the status.
"""
import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

LIMIT = 120  # s


class Starter:
    """The process that forks."""

    def __init__(self, root):
        self.process = subprocess.Popen([sys.executable, "-m", "tests.starter"], cwd=root, stdin=subprocess.PIPE,
            stdout=subprocess.PIPE, text=True)

    def run(self, *words):
        """The CompletedProcess of python -m tools.mesh WORDS in the root."""
        words = [str(word) for word in words]
        with tempfile.TemporaryDirectory() as folder:
            files = [str(Path(folder) / name) for name in ("out", "err")]
            self.process.stdin.write(json.dumps([words, *files]) + "\n")
            self.process.stdin.flush()
            status = int(self.process.stdout.readline())
            return subprocess.CompletedProcess(words, status, *(Path(file).read_text() for file in files))

    def end(self):
        self.process.stdin.close()
        self.process.wait()


def child(words, out, err):
    """The command, its output in two files; ends the process."""
    from tools.base.command import guarded
    from tools.meshing.main import main

    signal.alarm(LIMIT)
    for file, number in ((out, 1), (err, 2)):
        os.dup2(os.open(file, os.O_WRONLY | os.O_CREAT, 0o600), number)
    sys.argv, status = ["mesh", *words], 1
    try:
        guarded(main)
        status = 0
    except SystemExit as end:
        status = end.code or 0
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def serve():
    import gmsh  # noqa: F401
    import tools.meshing.main  # noqa: F401

    for line in sys.stdin:
        number = os.fork()
        if number == 0:
            child(*json.loads(line))
        print(os.waitstatus_to_exitcode(os.waitpid(number, 0)[1]), flush=True)


if __name__ == "__main__":
    serve()
