"""python -m tools.run_folder: says what a run folder holds (tools/base/summary.py).

In Python: from tools.run_folder import RunFolder (docs/guide/python.md)."""
from tools.base.command import guarded
from tools.base.run_folder import RunFolder
from tools.base.summary import main

__all__ = ["RunFolder"]

if __name__ == "__main__":
    guarded(main)
