"""python -m tools.watch: how far a run is (tools/watching/show.py)."""
from tools.base.command import guarded
from tools.watching.show import main

if __name__ == "__main__":
    guarded(main)
