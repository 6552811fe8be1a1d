"""The Python tools: python -m tools.NAME --help, in the project's .venv."""
import importlib.util
import sys

if importlib.util.find_spec("numpy") is None:
    print(f"error: {sys.executable} has no numpy; use .venv/bin/python (make setup makes it)", file=sys.stderr)
    raise SystemExit(3)
