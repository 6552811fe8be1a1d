"""A domain of one's own in three dimensions: volumes of a gmsh script (.geo) or tetrahedra of a mesh by gmsh (.msh), with sides
named by physical surfaces. What tools/meshing/own.py does in the plane.
"""
import sys

import numpy as np

from tools.base.command import BadInput
from tools.base.space_mesh import SpaceMesh
from tools.meshing.labels import LABELS
from tools.meshing.space_mesh import ordered, outer_faces, volumes

TETRAHEDRON, TRIANGLE = 4, 2  # gmsh's numbers of those without nodes on their edges
REMEDY = {"Tetrahedron": "Mesh.ElementOrder"}  # what makes other elements of a name; others are made by Recombine and the like


def has_volumes(gmsh):
    """Whether an open file is one in three dimensions: it has volumes, and names surfaces rather than curves, or names volumes."""
    return bool(gmsh.model.getEntities(3)) and bool(gmsh.model.getPhysicalGroups(3) or not gmsh.model.getPhysicalGroups(1))


def size_of(gmsh):
    """The size of the largest tetrahedra (of every twenty the largest) of a meshed model, in units of the script: the edge of a
    regular one of their volume. None where there are none."""
    _, points, corners = elements(gmsh, [-1])
    if not len(corners):
        return None
    return np.cbrt(6 * np.sqrt(2) * np.quantile(np.abs(volumes(points, corners)), 0.95))


def elements(gmsh, parts):
    """(row of each tag of a node, points (n, 3), corners (m, 4) of the tetrahedra of these volumes ([-1]: all), by row)."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    row = np.full(int(tags.max(initial=0)) + 1, -1)
    row[tags.astype(int)] = np.arange(len(tags))
    corners = np.concatenate([gmsh.model.mesh.getElementsByType(TETRAHEDRON, part)[1] for part in parts])
    return row, coordinates.reshape(-1, 3), row[corners.astype(int)].reshape(-1, 4)


def require_tetrahedra(gmsh, source, parts):
    """Raises BadInput where volumes ([-1]: all) hold other elements than tetrahedra of four nodes."""
    for part in parts:
        for kind in gmsh.model.mesh.getElementTypes(3, part):
            if kind != TETRAHEDRON:
                name, _, _, nodes, *_ = gmsh.model.mesh.getElementProperties(kind)
                name, number = name.split()[0], len(gmsh.model.mesh.getElementsByType(kind, part)[0])
                raise BadInput(f"'{source}' holds {number} elements of the kind {name} with {nodes} nodes; only tetrahedra of four "
                    f"nodes are taken: leave out {REMEDY.get(name, 'Recombine, Layers and Transfinite Volume with Recombine')}")


def read(gmsh, source, scale, parts, own):
    """The SpaceMesh of an open and meshed file; parts: its volumes ([-1]: all), own: labels of names of one's own. Raises
    BadInput."""
    require_tetrahedra(gmsh, source, parts)
    row, points, corners = elements(gmsh, parts)
    points = points * scale
    if not len(corners):
        raise BadInput(f"'{source}' holds no tetrahedra of four nodes" + (": gmsh writes what belongs to physical groups alone "
            "where there is one; add a Physical Volume and mesh it again" if source.suffix == ".msh" else ""))
    if not np.all(np.isfinite(points)):
        raise BadInput(f"'{source}' has a coordinate that is no finite number")
    used = points[np.unique(corners)]
    if len(np.unique(used, axis=0)) < len(used):
        raise BadInput(f"'{source}' has two nodes in one place: make neighbouring volumes share their surfaces (BooleanFragments, "
            f"Coherence)")
    labels = labels_of_faces(gmsh, row, points, own, source)
    points, corners = ordered(points, corners)
    triangles = outer_faces(corners)
    mesh = SpaceMesh(points, corners, triangles, named(points, triangles, labels, source))
    mesh.names = {label: name for name, label in own.items() if np.any(mesh.labels == label)}
    return mesh


def place(face):
    """What tells a triangle (3, 3) from others, whatever its points' numbers and order."""
    return frozenset(map(tuple, face))


def labels_of_faces(gmsh, row, points, own, source):
    """{place of a triangle: label} of the physical surfaces. Raises BadInput."""
    labels = {}
    for dimension, group in gmsh.model.getPhysicalGroups(2):
        name = gmsh.model.getPhysicalName(dimension, group)
        label = (LABELS | own)[name] if name else group  # a surface without a name has its number
        for surface in gmsh.model.getEntitiesForPhysicalGroup(dimension, group):
            _, corners = gmsh.model.mesh.getElementsByType(TRIANGLE, surface)
            for face in map(place, points[row[corners.astype(int)].reshape(-1, 3)]):
                if labels.setdefault(face, label) != label:
                    raise BadInput(f"'{source}' has a side in two physical surfaces, of labels {labels[face]} and {label}: name it "
                        f"once")
    return labels


def named(points, triangles, labels, source):
    """The labels of outer triangles, by their places. Raises BadInput where one has none."""
    sides = [place(face) for face in points[triangles]]
    found = np.array([labels.get(side, 0) for side in sides])
    if np.any(found == 0):
        x, y, z = points[triangles[found == 0][0]].mean(axis=0)
        raise BadInput(f"{np.sum(found == 0)} triangles of the boundary of '{source}' belong to no physical surface, one of them "
            f"at ({x:g}, {y:g}, {z:g}): name every side; within the domain neighbouring volumes must share their surfaces")
    inner = len(set(labels).difference(sides))
    if inner:
        print(f"warning: {inner} triangles of physical surfaces of '{source}' lie within the domain or outside it, and are left "
            f"out: a wall within the fluid needs two sides, cut it out as a thin hole", file=sys.stderr)
    return found
