"""python -m tools.sweep: runs over all combinations of values (tools/many/sweep.py)."""
from tools.base.command import guarded
from tools.many.sweep import main

if __name__ == "__main__":
    guarded(main)
