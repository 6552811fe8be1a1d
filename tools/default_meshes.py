"""python -m tools.default_meshes: makes the default meshes anew (tools/meshing/defaults.py)."""
from tools.base.command import guarded
from tools.meshing.defaults import main

if __name__ == "__main__":
    guarded(main)
