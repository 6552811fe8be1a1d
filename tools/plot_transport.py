"""python -m tools.plot_transport: pictures of carried particles (tools/plot/transport.py)."""
from tools.base.command import guarded
from tools.plot.transport import main

if __name__ == "__main__":
    guarded(main)
