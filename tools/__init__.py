"""The Python tools: python -m tools.NAME --help, in the project's .venv."""
import importlib.util
import sys

if importlib.util.find_spec("numpy") is None:
    print(f"error: {sys.executable} has no numpy; use .venv/bin/python (make setup makes it)", file=sys.stderr)
    raise SystemExit(3)

if sys.argv[:1] == ["-m"]:  # a tool begins, no other program that imports from here
    def stopped(kind, problem, trace):
        """What is said where Ctrl-C ends a tool that still reads its packages; later tools/base/command.py does."""
        if issubclass(kind, KeyboardInterrupt):
            print("stopped by the keyboard", file=sys.stderr)
        else:
            sys.__excepthook__(kind, problem, trace)
    sys.excepthook = stopped
