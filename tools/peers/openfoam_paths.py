"""The same spheres in OpenFOAM's flow and in the suite's own: the laminar pipe with diaphragm and obstacles.

    python -m tools.peers.openfoam_paths [CELLS ...] [--keep FOLDER]
    python -m tools.peers.openfoam_paths 10 --case FOLDER
    python -m tools.peers.openfoam_paths --own FILE

The flow has a parabola of 2 m/s at the inlet and a Reynolds number of 100 by it and the diameter. simpleFoam (finite volumes,
central differences) finds it on CELLS cells in the radius (default 10 20 40), python -m tools.flow makes it into a flow for
particles, and spheres of 2 mm, 2.5 times as dense as the fluid, start side by side behind the inlet. The same spheres go
through the flow of cases/pipe_flow.edp on the mesh of cases/pipe_transport.edp. Prints for each mesh a CSV row: the
largest difference of the heights at which they pass some places, over the radius, and of the times when they do, over
these times. --case makes instead, by icoFoam in FOLDER, the flow from rest until it is steady and a pulsating one after
that, and keeps of it what python -m tools.flow reads: tests/data/openfoam_pipe was made so. --own writes
the heights and times in the suite's own flow alone, which needs no OpenFOAM. About a minute; --case takes two.
"""
import contextlib
import gzip
import io
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from tools.base.command import ROOT, BadInput, Parser, guarded
from tools.base.runner import finished, run_case
from tools.base.run_folder import RunFolder
from tools.base.tables import write_table
from tools.flow.main import main as convert
from tools.peers.openfoam_case import dictionary, field, listed
from tools.peers.with_openfoam import Pipe

REYNOLDS, DENSITY = 100, 998.2
PLACES = 0.2, 0.3, 0.45, 0.6, 0.8, 0.95  # x, m
# Of --case: the inflow is steady until BEGIN (s), then 1 + SWING sin(2 pi (t - BEGIN)/PERIOD) times as large; what is kept
BEGIN, PERIOD, SWING = 4.0, 0.5, 0.8
TIMES = ["4", *(f"{5 + 0.05 * k:g}" for k in range(11))]
SCRIPT = "tests/transport/scripts/given.edp"
GIVEN = 'macro caseGiven() "" // EOM\n'
OWN = '''optDefault("-mesh", "meshes/pipe_transport.mesh");
macro caseSteady()1// EOM
macro caseCarrier() steadyCarrier("", "cases/pipe_flow.edp", "-vmax 2 -rhof " + rhoFluid + " -mu " + mu,
    "pipe_flow 2 parabola " + rhoFluid + " " + mu + " 0.05 0.07 0", "laminar", meshFile); // EOM
'''
SCHEMES = """ddtSchemes {{ default {time}; }} gradSchemes {{ default Gauss linear; }} interpolationSchemes {{ default linear; }}
divSchemes {{ default none; div(phi,U) {bounded} Gauss linear; div((nuEff*dev2(T(grad(U))))) Gauss linear; }}
laplacianSchemes {{ default Gauss linear corrected; }} snGradSchemes {{ default corrected; }}"""
SOLUTION = """solvers { "p.*" { solver GAMG; smoother GaussSeidel; tolerance 1e-9; relTol 0.02; }
    pFinal { solver GAMG; smoother GaussSeidel; tolerance 1e-9; relTol 0; }
    U { solver smoothSolver; smoother symGaussSeidel; tolerance 1e-12; relTol 0.05; } }
SIMPLE { consistent yes; residualControl { ".*" 1e-8; } } relaxationFactors { equations { ".*" 0.9; } }
PISO { nCorrectors 3; nNonOrthogonalCorrectors 1; pRefCell 0; pRefValue 0; }"""
CONTROL = """startFrom startTime; startTime 0; stopAt endTime; endTime {end}; deltaT {step}; {writing}
writeFormat ascii; writePrecision {digits}; writeCompression on; timeFormat general; runTimeModifiable false;"""


def solve(cells, folder, steady):
    """Runs simpleFoam (steady) or icoFoam (from rest, and pulsating) in the folder, with `cells` cells in the radius. Raises
    BadInput."""
    flow = Pipe()
    mesh, program = flow.mesh(cells), "simpleFoam" if steady else "icoFoam"
    mesh.write(folder / "constant" / "polyMesh", 0.1 * flow.scale)
    y = mesh.along("inlet")[1][:, 1]
    nu = flow.speed * flow.scale / REYNOLDS
    if steady:
        control = CONTROL.format(digits=7, end=3000, step=1, writing="writeControl timeStep; writeInterval 3000;")
    else:
        control = CONTROL.format(digits=5, end=TIMES[-1], step=0.005 / cells, writing="writeControl runTime; writeInterval 0.05;")
    files = {"constant/transportProperties": f"transportModel Newtonian; nu [0 2 -1 0 0 0 0] {nu:g};",
             "constant/turbulenceProperties": "simulationType laminar;", "system/controlDict": f"application {program}; {control}",
             "system/fvSchemes": SCHEMES.format(time="steadyState" if steady else "backward", bounded="bounded" if steady else ""),
             "system/fvSolution": SOLUTION}
    for name, text in files.items():
        dictionary(folder / name, "dictionary", text)
    inflow = "fixedValue; value " + field(np.column_stack([flow.inlet(y), 0 * y]))
    if not steady:
        inflow = "timeVaryingMappedFixedValue; offset (0 0 0); setAverage off; mapMethod nearest"
        given = folder / "constant" / "boundaryData" / "inlet"
        pulses = [BEGIN + PERIOD * k / 40 for k in range(int(40 * (float(TIMES[-1]) - BEGIN) / PERIOD) + 1)]
        for time in (0.0, *pulses):
            (given / f"{time:.12g}").mkdir(parents=True)
            factor = 1 + SWING * np.sin(2 * np.pi * (time - BEGIN) / PERIOD) if time >= BEGIN else 1
            (given / f"{time:.12g}" / "U").write_text(listed(np.column_stack([factor * flow.inlet(y), 0 * y, 0 * y])) + "\n")
        (given / "points").write_text(listed(np.column_stack([0 * y, y, 0 * y + 0.05 * flow.scale])) + "\n")
    fields = {"U": ("0 1 -1", (inflow, "zeroGradient", "noSlip", "uniform (0 0 0)")),
              "p": ("0 2 -2", ("zeroGradient", "fixedValue; value uniform 0", "zeroGradient", "uniform 0"))}
    for name, (size, kinds) in fields.items():
        patches = " ".join(f"{patch} {{ type {kind}; }}" for patch, kind in zip(("inlet", "outlet", "wall"), kinds))
        dictionary(folder / "0" / name, "volVectorField" if name == "U" else "volScalarField", f"dimensions [{size} 0 0 0 0];\n"
            f"internalField {kinds[3]};\nboundaryField {{ {patches} sides {{ type empty; }} }}")
    environment = {"WM_PROJECT_DIR": "/usr/share/openfoam", **os.environ, "PWD": str(folder)}
    done = subprocess.run([program], cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        check=False)
    (folder / "log").write_text(done.stdout, encoding="utf-8")
    if done.returncode:
        raise BadInput(f"{program} ended with status {done.returncode}, its last words: {done.stdout[-300:]}")


def keep(made, folder):
    """Copies what tools.flow reads of a case: the mesh, gzipped, and U at TIMES."""
    (folder / "constant" / "polyMesh").mkdir(parents=True)
    for file in sorted((made / "constant" / "polyMesh").iterdir()):
        if file.name == "boundary":
            shutil.copy(file, folder / "constant" / "polyMesh")
        elif file.name != "neighbour":
            packed = gzip.compress(file.read_bytes(), mtime=0)
            (folder / "constant" / "polyMesh" / f"{file.name}.gz").write_bytes(packed)
    for time in TIMES:
        (folder / time).mkdir()
        packed = gzip.compress(gzip.decompress((made / time / "U.gz").read_bytes()), mtime=0)
        (folder / time / "U.gz").write_bytes(packed)
    (folder / "case.foam").touch()


def passages(particles):
    """{(place, id): (height, time)} at which spheres pass PLACES."""
    found = {}
    for name in np.unique(particles["id"]):
        x, y, t = (particles[column][particles["id"] == name] for column in "xyt")
        for place in PLACES:
            for k in np.flatnonzero((x[:-1] < place) & (x[1:] >= place))[:1]:
                share = (place - x[k]) / (x[k + 1] - x[k])
                found[place, name] = tuple(column[k] + share * (column[k + 1] - column[k]) for column in (y, t))
    return found


def spheres(script, out, **options):
    """The passages of the spheres in a flow."""
    options = {"-rhof": DENSITY, "-mu": DENSITY * Pipe.speed * Pipe.scale / REYNOLDS, "-density": 2.5 * DENSITY, "-radius": 0.001,
        "-start-x": 0.02, "-low": -0.08, "-high": 0.07, "-number": 8, "-dt": 0.001, "-tend": 2, **options}
    finished(run_case(script, options, out=out))
    return passages(RunFolder(out).particles)


def main():
    parser = Parser(prog="python -m tools.peers.openfoam_paths", description=__doc__)
    parser.add_argument("cells", metavar="CELLS", type=int, nargs="*", help="cells in the radius, even (default 10 20 40)")
    parser.add_argument("--keep", metavar="FOLDER", type=Path, help="keep OpenFOAM's files there")
    parser.add_argument("--mesh", metavar="FILE", type=Path, help="compare instead the suite's own flow on this mesh (python -m "
        "tools.mesh pipe_transport)")
    parser.add_argument("--own", metavar="FILE", type=Path, help="write the heights and times in the suite's own flow to a "
        "CSV file")
    parser.add_argument("--case", metavar="FOLDER", type=Path, help="make the start of the flow instead, in this new folder")
    given = parser.parse_args()
    cells = given.cells or [10, 20, 40]
    if min(cells) < 4 or any(n % 2 for n in cells) or given.case and len(cells) > 1:
        raise BadInput("CELLS are even numbers from 4 on; one of them for --case")
    if not shutil.which("simpleFoam") and not (given.own or given.mesh):
        raise BadInput("simpleFoam is not there; Debian's package openfoam has it")
    if given.case and given.case.exists():
        raise BadInput(f"{given.case} is there already; name another folder")
    with tempfile.TemporaryDirectory() as scratch:
        if given.case:
            solve(cells[0], Path(scratch) / "case", steady=False)
            keep(Path(scratch) / "case", given.case)
            return 0
        base = given.keep or Path(scratch)
        own = Path(scratch) / "own.edp"
        own.write_text((ROOT / SCRIPT).read_text().replace(GIVEN, OWN))
        target = spheres(own, Path(scratch) / "own")
        if given.own:
            write_table(given.own, ["x", "id", "y", "t"], [(*key, *target[key]) for key in sorted(target)], [
                "Heights y (m) and times t (s) at which spheres pass x in the suite's own flow: python -m "
                "tools.peers.openfoam_paths --own"])
            return 0
        for n in [str(given.mesh)] if given.mesh else cells:
            if given.mesh:
                found = spheres(own, Path(scratch) / "mesh", **{"-mesh": given.mesh})
            else:
                solve(n, base / f"pipe_{n}", steady=True)
                with contextlib.redirect_stdout(io.StringIO()):
                    convert([str(base / f"pipe_{n}"), "--out", str(base / f"flow_{n}")])
                found = spheres(SCRIPT, Path(scratch) / f"run_{n}", **{"-flow": base / f"flow_{n}"})
            height, time = np.abs([np.subtract(found[key], target[key]) / (0.5 * Pipe.scale, target[key][1]) for key in target
                if key in found]).max(axis=0)
            if n in (cells[0], str(given.mesh)):
                print("cells,passages,of,height_difference,time_difference")
            print(f"{n},{len(set(found) & set(target))},{len(target)},{height:.4g},{time:.4g}", flush=True)
    return 0


if __name__ == "__main__":
    guarded(main)
