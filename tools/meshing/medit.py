"""Writing a mesh in the medit form that FreeFEM's readmesh reads with labels."""
import os
from pathlib import Path

import meshio
import numpy as np

from tools.base.command import BadInput
from tools.meshing.labels import LABELS

# A vertex where two labels meet takes the later one of this list.
PRECEDENCE = ["inlet", "outlet", "axis", "left", "right", "bottom", "top", "wall", "obstacle", "diaphragm", "lid", "cylinder"]


def write(mesh, file):
    """Writes a PlaneMesh to a .mesh file, whole or not at all; folders are made.

    Raises BadInput when the file cannot be written.
    """
    file = Path(file)
    vertex_labels = np.zeros(len(mesh.points), dtype=int)
    for label in mesh.names:
        vertex_labels[mesh.edges[mesh.edge_labels == label]] = label
    for name in PRECEDENCE:
        vertex_labels[mesh.edges[mesh.edge_labels == LABELS[name]]] = LABELS[name]
    content = meshio.Mesh(
        mesh.points[:, :2],
        [("line", mesh.edges), ("triangle", mesh.triangles)],
        point_data={"medit:ref": vertex_labels},
        cell_data={"medit:ref": [mesh.edge_labels, np.zeros(len(mesh.triangles), dtype=int)]},
    )
    store(content, file, mesh.names, "Dimension 2\n", ".15g")


def store(content, file, names, heading, digits):
    """Writes a meshio.Mesh whole or not at all, the names of sides {label: name} as comments behind the line `heading`.

    Raises BadInput when the file cannot be written.
    """
    temporary = file.with_name(f".{file.name}.{os.getpid()}.mesh")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        meshio.write(temporary, content, file_format="medit", float_fmt=digits)
        if names:
            head, heading, rest = temporary.read_text(encoding="utf-8").partition(heading)
            sides = "".join(f"# side {label} {name}\n" for label, name in sorted(names.items()))
            temporary.write_text(head + heading + sides + rest, encoding="utf-8")
        os.replace(temporary, file)
    except OSError as problem:
        raise BadInput(f"cannot write the mesh to '{file}': {problem.strerror}") from None
    finally:
        temporary.unlink(missing_ok=True) if temporary.parent.is_dir() else None
