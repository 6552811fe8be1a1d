"""python -m tools.mesh: the mesh of a case (tools/meshing/main.py)."""
import sys

from tools.base.command import guarded

try:
    from tools.meshing.main import main
except ModuleNotFoundError as missing:
    if missing.name.startswith("tools"):
        raise
    print(f"error: the Python package {missing.name} is not installed: run make setup, then .venv/bin/python -m tools.mesh",
        file=sys.stderr)
    sys.exit(3)

if __name__ == "__main__":
    guarded(main)
