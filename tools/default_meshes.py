"""python -m tools.default_meshes [CASE ...]: makes the default meshes of meshes/ anew.

Each is what python -m tools.mesh CASE makes when no option is given.
"""
import sys

from tools.command import ROOT, BadInput, guarded
from tools.mesh import make, parser
from tools.meshing import CASES
from tools.meshing.checks import summary
from tools.meshing.medit import write


def main():
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(__doc__.strip())
        return 0
    unknown = [name for name in sys.argv[1:] if name not in CASES]
    if unknown:
        raise BadInput(f"no default mesh is named '{unknown[0]}'; known: {', '.join(CASES)}")
    for case in sys.argv[1:] or CASES:
        file = ROOT / "meshes" / f"{case}.mesh"
        mesh, found = make(parser().parse_args([case, "--out", str(file)]))
        if found:
            raise BadInput(f"{case}: {found[0]}")
        write(mesh, file)
        print(f"meshes/{case}.mesh: {summary(mesh)}\n")
    return 0


if __name__ == "__main__":
    guarded(main)
