"""python -m tools.compress: the fields of a run in less room (tools/plot/compress.py)."""
from tools.base.command import guarded
from tools.plot.compress import main

if __name__ == "__main__":
    guarded(main)
