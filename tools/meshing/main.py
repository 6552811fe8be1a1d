"""python -m tools.mesh RECIPE --size 0.01 --out FILE: the mesh of a case, by gmsh or on a grid.

Most cases have a recipe under their name (python -m tools.mesh RECIPE --help lists its
options; the template and other boxes: `box`); `own` takes a gmsh script or mesh of yours. The mesh is checked before it is written:
all labels there, labelled edges equal
to the sides of the domain, no inverted or sliver element. The file is read by FreeFEM's
readmesh with labels.

Exit statuses: 0 written, 3 bad option or file (one line), 4 a mesh that failed its check.
"""
import sys
from pathlib import Path

from tools.base.command import BadInput, Parser
from tools.meshing import RECIPES, medit, space_mesh
from tools.meshing.checks import LEAST_ANGLE, faults, histogram, slivers, summary

FAILED_CHECK = 4


def parser():
    top = Parser(prog="python -m tools.mesh", description=__doc__)
    cases = top.add_subparsers(dest="case", metavar="CASE", required=True)
    for name, (recipe, defaults) in RECIPES.items():
        about = recipe.__doc__.split("\n")[0]
        one = cases.add_parser(name, prog=f"python -m tools.mesh {name}", help=about, description=recipe.__doc__)
        one.add_argument("--out", metavar="FILE", required=True, help="the .mesh file to write; replaced if it is there")
        one.add_argument("--quality", action="store_true", help="print a histogram of the angles")
        recipe.add_options(one)
        one.set_defaults(**defaults)
    return top


def make(options):
    """The mesh of parsed options, checked: (mesh, list of faults)."""
    outline, mesh = RECIPES[options.case][0].build(options)
    if isinstance(mesh, space_mesh.SpaceMesh):
        return mesh, space_mesh.faults(mesh)
    return mesh, faults(mesh, outline, least_angle=getattr(RECIPES[options.case][0], "LEAST_ANGLE", LEAST_ANGLE))


def write(mesh, file):
    """Writes a checked mesh, of either kind, and returns its summary."""
    if isinstance(mesh, space_mesh.SpaceMesh):
        space_mesh.write(mesh, file)
        return space_mesh.summary(mesh)
    medit.write(mesh, file)
    return summary(mesh)


def is_foreign(path):
    """True for a file that is there and is no mesh of this format."""
    try:
        return path.exists() and "MeshVersionFormatted" not in path.read_bytes()[:200].decode("latin-1")
    except OSError:
        return True


def main():
    options, unknown = parser().parse_known_args()
    if unknown:
        raise BadInput(f"{' '.join(unknown)}: not known to {options.case} (python -m tools.mesh {options.case} --help lists its "
            f"options)")
    path = Path(options.out)
    if path.suffix != ".mesh" or any(sign.isspace() for sign in path.name):
        raise BadInput(f"--out needs a file name without spaces that ends with .mesh, not '{options.out}'")
    if is_foreign(path):
        raise BadInput(f"'{options.out}' is there and is no mesh; give another name")
    if path.name == "mesh.mesh" and (path.parent / "run.json").is_file():
        raise BadInput(f"'{options.out}' is the mesh of a run, whose results belong to it; give another name")
    mesh, found = make(options)
    if found:
        remedy = getattr(RECIPES[options.case][0], "REMEDY", "ask for smaller elements or other dimensions")
        print(f"error: the mesh was not written: {found[0]}; {remedy}", file=sys.stderr)
        return FAILED_CHECK
    print(f"{options.out}: {write(mesh, options.out)}")
    if not isinstance(mesh, space_mesh.SpaceMesh) and slivers(mesh):
        print(f"warning: {slivers(mesh)} of the {len(mesh.triangles)} triangles have an angle below {LEAST_ANGLE:g} degrees",
            file=sys.stderr)
    if options.quality and not isinstance(mesh, space_mesh.SpaceMesh):
        print(histogram(mesh))
    return 0
