"""python -m tools.bodies: the particles of a run and their contacts as files for ParaView (tools/plot/bodies.py)."""
from tools.base.command import guarded
from tools.plot.bodies import main

if __name__ == "__main__":
    guarded(main)
