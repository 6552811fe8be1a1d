"""python -m tools.rerun: repeats a run from its folder (tools/many/rerun.py)."""
from tools.base.command import guarded
from tools.many.rerun import main

if __name__ == "__main__":
    guarded(main)
