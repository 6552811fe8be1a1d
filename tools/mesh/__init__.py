"""python -m tools.mesh: the mesh of a case (tools/meshing/main.py)."""
