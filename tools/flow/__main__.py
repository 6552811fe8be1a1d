"""python -m tools.flow: a flow that another program has computed, for point particles (tools/flow/main.py)."""
import sys

from tools.base.command import guarded

try:
    from tools.flow.main import main
except ModuleNotFoundError as missing:
    if missing.name.startswith("tools"):
        raise
    print(f"error: the Python package {missing.name} is not installed: run make setup, then .venv/bin/python -m tools.flow",
        file=sys.stderr)
    sys.exit(3)

if __name__ == "__main__":
    guarded(main)
