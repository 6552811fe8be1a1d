"""python -m tools.plot_steady: pictures of steady flows (tools/plot/steady.py)."""
from tools.base.command import guarded
from tools.plot.steady import main

if __name__ == "__main__":
    guarded(main)
