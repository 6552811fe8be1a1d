"""python -m tools.default_meshes [CASE ...]: makes the default meshes of meshes/ anew.

Each is what python -m tools.mesh CASE makes when no option is given, or what a gmsh script meshes/CASE.geo says.
"""
import sys

from tools.base.command import ROOT, BadInput
from tools.meshing import CASES
from tools.meshing.main import make, parser, write


def main():
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(__doc__.strip())
        return 0
    known = {case: [case] for case in CASES} | {path.stem: ["own", "--from", str(path)]
        for path in sorted((ROOT / "meshes").glob("*.geo"))}
    unknown = [name for name in sys.argv[1:] if name not in known]
    if unknown:
        raise BadInput(f"no default mesh is named '{unknown[0]}'; known: {', '.join(known)}")
    for case in sys.argv[1:] or known:
        file = ROOT / "meshes" / f"{case}.mesh"
        mesh, found = make(parser().parse_args([*known[case], "--out", str(file)]))
        if found:
            raise BadInput(f"{case}: {found[0]}")
        print(f"meshes/{case}.mesh: {write(mesh, file)}\n")
    return 0
