"""A domain of your own: a gmsh script (.geo) or a mesh by gmsh (.msh), its sides named by physical curves.

A file with volumes gives a mesh of tetrahedra, for spheres. What is said of curves here holds there for surfaces, and what is
said of surfaces for volumes.

Each side of the domain belongs to a physical curve whose name is a boundary of the project
(wall, inlet, outlet, obstacle, left, right ...; lib/mesh/labels.idp) or one of your own, which gets a label from
21 on and stands in the head of the mesh; without a name the curve's number is the label:

    Physical Curve("wall") = {1, 3}; Physical Curve("inlet") = {4}; Physical Curve("outlet") = {2};
    Physical Surface("fluid") = {1};

A physical curve within the domain is left out, with a warning; so are surfaces of a script that belong
to no physical surface where there is one. A script is meshed with its own element sizes, or with --size
where those are larger (transfinite curves keep their points), and scaled by its Mesh.ScalingFactor; --size
is a size of the scaled mesh. For a refinement study of a script with several sizes add --proportional: all sizes
by one factor, so that the largest elements are of --size. With --size it is meshed anew, whatever commands Mesh and RefineMesh the
script has. Sides of a period need matching nodes (gmsh: Periodic Curve).
"""
import re
import sys
from functools import partial
from pathlib import Path

import numpy as np

from tools.base.command import BadInput, positive
from tools.base.text_files import bytes_of, text_of
from tools.meshing import own_space
from tools.meshing.labels import LABELS, own_labels
from tools.meshing.plane_mesh import finished, signed_areas
from tools.meshing.unstructured import extracted, with_gmsh

KINDS = (".geo", ".msh")
TRIANGLE = 2  # gmsh's number of the triangle of three nodes
REMEDY = "mend it in the program it comes from, or take other sizes"  # of a mesh that fails its check
LEAST_ANGLE = 0.1  # degrees; layers of thin triangles at a wall are wanted
MOST = {2: 1e8, 3: 1e7}  # squares, or cubes, of the element size in the box round a domain


def add_options(parser):
    parser.add_argument("--from", dest="source", metavar="FILE", required=True, help="gmsh script (.geo) or mesh (.msh)")
    parser.add_argument("--size", type=positive, metavar="L", help="of a script: largest element size (default: that of the "
        "script)")
    parser.add_argument("--proportional", action="store_true", help="with --size: all sizes of the script by one factor, so that "
        "its largest elements are of this size")


def build(options):
    source = Path(options.source)
    if source.suffix not in KINDS:
        raise BadInput(f"--from takes a gmsh script (.geo) or mesh (.msh), not '{source}'")
    called = f"'{source}'"
    if source.suffix == ".msh":
        bytes_of(source, called)
    elif text_of(source, called, "replace").rpartition("\n")[2].strip():
        raise BadInput(f"'{source}' ends without a newline; gmsh drops statements of its last line: add one")
    return None, with_gmsh(lambda gmsh: read(gmsh, source, options.size, options.proportional, (2, 3)), f"gmsh cannot make a mesh "
        f"of '{source}'")


def proportional(gmsh, scale, factor, size, dimension):
    """Sets gmsh's factor on all sizes so that the largest elements (of every twenty the largest) are of this size. Raises
    BadInput."""
    gmsh.model.mesh.clear()  # of commands Mesh of the script
    gmsh.model.mesh.generate(dimension)
    if dimension == 3:
        count, largest = len(gmsh.model.mesh.getElementsByType(own_space.TETRAHEDRON)[0]), own_space.size_of(gmsh)
    else:
        points, triangles, _ = extracted(gmsh, [-1])
        areas = abs(signed_areas(points[:, :2], triangles))
        count, largest = len(areas), np.sqrt(4 / np.sqrt(3) * np.quantile(areas, 0.95)) if len(areas) else None
    if not count:
        return
    largest *= scale
    if count * (largest / size) ** dimension > MOST[dimension]:
        raise BadInput(f"--size {size:g} makes more than {MOST[dimension]:g} {'tetrahedra' if dimension == 3 else 'triangles'}")
    gmsh.model.mesh.clear()
    gmsh.option.setNumber("Mesh.MeshSizeFactor", factor * size / largest)


def require_triangles(gmsh, source, surfaces):
    """Raises BadInput where surfaces ([-1]: all) hold other elements than triangles of three nodes."""
    for surface in surfaces:
        for kind in gmsh.model.mesh.getElementTypes(2, surface):
            if kind != TRIANGLE:
                number, (name, _, _, nodes, *_) = len(gmsh.model.mesh.getElementsByType(kind,
                    surface)[0]), gmsh.model.mesh.getElementProperties(kind)
                remedy = "Recombine" if name.startswith("Quad") else "Mesh.ElementOrder"
                raise BadInput(f"'{source}' holds {number} {name.split()[0].lower()}s of {nodes} nodes; only triangles of three "
                    f"nodes are taken: leave out {remedy}")


def read(gmsh, source, size, all_sizes=False, dimensions=(2,)):
    """The PlaneMesh of a file, meshed if it is a script, or with dimensions (2, 3) the SpaceMesh of one with volumes; all_sizes:
    --proportional. Raises BadInput."""
    if all_sizes and not size:
        raise BadInput("--proportional needs --size")
    if source.suffix == ".geo" and re.search(r"^[ \t]*Exit[ \t]*;", source.read_text(encoding="utf-8", errors="replace"),
        re.MULTILINE):
        raise BadInput(f"'{source}' has the command Exit, which ends the program before there is a mesh: take it out")
    gmsh.open(str(source))
    scale, surfaces, dimension = 1.0, [-1], 3 if own_space.has_volumes(gmsh) else 2
    if dimension not in dimensions:
        raise BadInput(f"'{source}' has volumes, which are for spheres in three dimensions; a plane mesh is needed here")
    if source.suffix == ".geo":
        scale, surfaces = meshed(gmsh, source, size, all_sizes, dimension)
    elif size:
        raise BadInput(f"--size is for scripts; '{source}' is meshed already")
    own = own_names(gmsh, source, dimension - 1)
    if dimension == 3:
        return own_space.read(gmsh, source, scale, surfaces, own)
    require_triangles(gmsh, source, surfaces)
    points, triangles, number = extracted(gmsh, surfaces)
    points *= scale
    if not np.all(np.isfinite(points)):
        raise BadInput(f"'{source}' has a coordinate that is no finite number")
    if len(triangles) == 0:
        raise BadInput(f"'{source}' holds no triangles of three nodes" + (": with --size none are taken of a mesh that a script "
            "merges" if size else
                       ": gmsh writes what belongs to physical groups alone where there is one; add a Physical Surface and mesh "
                           "it again" if source.suffix == ".msh" else ""))
    if np.ptp(points[:, 2]) > 1e-9 * np.ptp(points[:, :2]):
        raise BadInput(f"'{source}' is not plane: z reaches from {points[:, 2].min():g} to {points[:, 2].max():g}")
    points = points[:, :2]
    if len(np.unique(points, axis=0)) < len(points):
        raise BadInput(f"'{source}' has two nodes in one place: remove duplicates, or give matching sides one curve")
    mesh = finished(points, triangles, partial(named, labels=labels_of_edges(gmsh, points, number, own, source), source=source))
    mesh.names = {label: name for name, label in own.items() if np.any(mesh.edge_labels == label)}
    return mesh


def own_names(gmsh, source, dimension):
    """{name: label} of the physical curves, or surfaces (dimension 2), that have names of one's own, in the order of their numbers.
    Raises BadInput."""
    kind = "Surface" if dimension == 2 else "(Curve|Line)"
    if source.suffix == ".geo" and re.search(rf"""^[^/\n]*\bPhysical\s+{kind}\s*\(\s*(""|'')\s*\)""", text_of(source, f"'{source}'",
        "replace"), re.MULTILINE):
        raise BadInput(f"'{source}' has a side whose name is empty: gmsh would take the next number, which may be the label of "
            f"another side; give it a name, or a number in place of the name")
    groups = gmsh.model.getPhysicalGroups(dimension)
    try:
        names = {group: gmsh.model.getPhysicalName(dimension, group) for _, group in groups}
        found = own_labels(filter(None, names.values()), {group for group, name in names.items() if not name})
    except UnicodeDecodeError:
        raise BadInput(f"'{source}' names a side by letters that are no UTF-8 text; save the file as UTF-8 text") from None
    except BadInput as problem:
        raise BadInput(f"'{source}': {problem}") from None
    for name, label in found.items():
        if not name.isascii():
            print(f"warning: no script can hold the name '{name}', for FreeFEM reads plain letters alone: a case writes the label "
                f"{label} for it", file=sys.stderr)
    return found


def meshed(gmsh, source, size, all_sizes, dimension):
    """Meshes an open script; its Mesh.ScalingFactor and the surfaces, or volumes, that gmsh would write ([-1]: all). Raises
    BadInput."""
    scale, factor, largest, least, every = (gmsh.option.getNumber("Mesh." + name) for name in ("ScalingFactor", "MeshSizeFactor",
        "MeshSizeMax", "MeshSizeMin", "SaveAll"))
    if not (scale > 0 and factor > 0):
        raise BadInput(f"'{source}' has Mesh.ScalingFactor {scale:g} and Mesh.MeshSizeFactor {factor:g}: both must be above 0")
    if size and all_sizes:
        proportional(gmsh, scale, factor, size, dimension)
    elif size:
        bounds = scale * np.array(gmsh.model.getBoundingBox(-1, -1))
        box = (bounds[3:] - bounds[:3])[:dimension]
        if np.prod(box / size) > MOST[dimension]:
            raise BadInput(f"--size {size:g} makes more than {MOST[dimension]:g} {'tetrahedra' if dimension == 3 else 'triangles'} "
                f"of a domain of {' times '.join(f'{one:g}' for one in box)}")
        largest = min(largest, size / scale / factor)  # gmsh takes the factor after the bounds
        gmsh.option.setNumber("Mesh.MeshSizeMax", largest)
        gmsh.option.setNumber("Mesh.MeshSizeMin", min(least, largest))
        gmsh.model.mesh.clear()  # curves that a command Mesh of the script has divided would stay as they are
    gmsh.model.mesh.generate(dimension)
    groups = [] if every else gmsh.model.getPhysicalGroups(dimension)
    return scale, sorted({tag for pair in groups for tag in gmsh.model.getEntitiesForPhysicalGroup(*pair)}) or [-1]


def labels_of_edges(gmsh, points, number, own, source):
    """{places of an edge: label} of the physical curves; number: of each node's tag, the point's (below 0: none); own: labels of
    names of one's own. Raises BadInput."""
    labels, outside = {}, 0
    for dimension, group in gmsh.model.getPhysicalGroups(1):
        name = gmsh.model.getPhysicalName(dimension, group)
        label = (LABELS | own)[name] if name else group  # a curve without a name has its number
        for curve in gmsh.model.getEntitiesForPhysicalGroup(dimension, group):
            _, ends = gmsh.model.mesh.getElementsByType(1, curve)
            ends = number[ends.astype(int)].reshape(-1, 2)
            outside += np.sum(ends.min(axis=1) < 0)
            for edge in map(places, points[ends[ends.min(axis=1) >= 0]]):
                if labels.setdefault(edge, label) != label:
                    raise BadInput(f"'{source}' has a side in two physical curves, of labels {labels[edge]} and {label}: name it "
                        f"once")
    if outside:
        print(f"warning: {outside} edges of physical curves of '{source}' lie outside the domain and are left out", file=sys.stderr)
    return labels


def places(edge):
    """What tells an edge (2, 2) from others, whatever its points' numbers and order."""
    return frozenset(map(tuple, edge))


def named(points, edges, labels, source):
    """The labels of boundary edges, by their places."""
    sides = [places(edge) for edge in points[edges]]
    found = np.array([labels.get(edge, 0) for edge in sides])
    if np.any(found == 0):
        a, b = points[edges[found == 0][0]]
        raise BadInput(f"{np.sum(found == 0)} boundary edges of '{source}' belong to no physical curve, the first from "
            f"({a[0]:g}, {a[1]:g}) to ({b[0]:g}, {b[1]:g}): name every side; within the domain a triangle is missing, or does not "
            f"meet its neighbours vertex to vertex")
    inner = set(labels).difference(sides)
    if inner:
        a, b = min(sorted(edge) for edge in inner)
        print(f"warning: {len(inner)} edges of physical curves of '{source}' lie within the domain, one from ({a[0]:g}, "
            f"{a[1]:g}) to ({b[0]:g}, {b[1]:g}), and are left out: "
              "a wall within the fluid needs two sides, cut it out as a thin hole", file=sys.stderr)
    return found
