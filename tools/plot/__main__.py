"""python -m tools.plot: pictures and the film of a run (tools/plot/resolved.py)."""
from tools.base.command import guarded
from tools.plot.resolved import main

if __name__ == "__main__":
    guarded(main)
