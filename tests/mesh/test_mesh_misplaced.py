"""Meshes of other programs with a vertex in a wrong place, in several regions, with thin triangles."""
import numpy as np
import pytest

from tests.conftest import ROOT
from tests.starter import Starter
from tests.tables import read_medit
from tools.meshing.checks import folded

N = 6
READ = """include "lib/mesh/read_mesh.idp"
mesh Th = meshRead("FILE");
cout << "SIDES " << Th.nbe << " " << Th.measure << endl;"""


def square():
    """Points ((N + 1)^2, 2), triangles and labelled sides (.., 3) of a unit square."""
    i, j = np.meshgrid(range(N + 1), range(N + 1))
    a = np.array([row * (N + 1) + k for row in range(N) for k in range(N)])
    triangles = np.concatenate([np.column_stack([a, a + 1, a + N + 2]), np.column_stack([a, a + N + 2, a + N + 1])])
    k, m = np.arange(N), (N + 1) * np.arange(N)
    ends = [(k, k + 1), (m + N, m + 2 * N + 1), (k + N * (N + 1), k + 1 + N * (N + 1)), (m, m + N + 1)]
    sides = np.concatenate([np.column_stack([p, q, np.full(N, 3)]) for p, q in ends])
    return np.column_stack([i.ravel(), j.ravel()]) / N, triangles, sides


def write(file, points, triangles, sides, regions=None):
    """A file by Medit (.mesh) or gmsh 2.2 (.msh)."""
    regions = np.ones(len(triangles), int) if regions is None else regions
    if file.suffix == ".mesh":
        rows = [f"MeshVersionFormatted 2\nDimension 2\nVertices\n{len(points)}", *(f"{x:.15g} {y:.15g} 0" for x, y in points),
            f"Edges\n{len(sides)}", *(f"{a + 1} {b + 1} {label}" for a, b, label in sides), f"Triangles\n{len(triangles)}",
            *(f"{a + 1} {b + 1} {c + 1} {region}" for (a, b, c), region in zip(triangles, regions)), "End\n"]
    else:
        elements = [f"1 2 {label} {label} {a + 1} {b + 1}" for a, b, label in sides]
        elements += [f"2 2 {region} {region} {a + 1} {b + 1} {c + 1}" for (a, b, c), region in zip(triangles, regions)]
        rows = ["$MeshFormat\n2.2 0 8\n$EndMeshFormat", f"$Nodes\n{len(points)}",
            *(f"{k + 1} {x:.15g} {y:.15g} 0" for k, (x, y) in enumerate(points)), "$EndNodes", f"$Elements\n{len(elements)}",
            *(f"{k + 1} {row}" for k, row in enumerate(elements)), "$EndElements\n"]
    file.write_text("\n".join(rows))
    return file


MIDDLE = (N + 1) * (N // 2) + N // 2


def moved(to):
    """The square with its vertex of the middle elsewhere."""
    points, triangles, sides = square()
    points[MIDDLE] = to
    return points, triangles, sides


def turned(points, triangles):
    """The triangles counter-clockwise, as programs leave them that look at each alone."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    back = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    return np.where(back[:, None], triangles[:, [0, 2, 1]], triangles)


def read(freefem_text, file, **more):
    return freefem_text(READ.replace("FILE", str(file)), **more)


def test_triangles_that_lie_on_each_other_are_refused_by_a_run(freefem_text, tmp_path):
    """readmesh ended with "bamg2msh: missing vertices" and status 8."""
    points, triangles, sides = moved((0.75, 0.58))
    triangles = turned(points, triangles)
    done = read(freefem_text, write(tmp_path / "bad.mesh", points, triangles, sides), check=False)
    assert done.returncode == 3 and "triangles that lie on each other, one of them at (" in done.stderr, done.stderr
    assert len(folded(triangles)) and not len(folded(square()[1]))


@pytest.mark.parametrize("height, status", [(1e-5, 3), (1e-3, 0)])
def test_a_triangle_without_width_is_refused_and_a_thin_one_taken(height, status, freefem_text, tmp_path):
    points, triangles, sides = square()
    points[MIDDLE] = (points[MIDDLE - N - 2] + points[MIDDLE - N - 1]) / 2 + (0, height / N)  # above the side of a triangle
    done = read(freefem_text, write(tmp_path / "thin.mesh", points, triangles, sides), check=False)
    assert done.returncode == status, done.stderr
    assert status == 0 or "below a hundredth of a degree" in done.stderr


def test_a_mesh_of_several_regions_has_the_sides_of_one(freefem_text, tmp_path):
    """It was refused: "the labelled edges do not close the boundary"."""
    points, triangles, sides = square()
    for name, regions in (("one", None), ("two", 1 + (points[triangles].mean(axis=1)[:, 0] > 0.4)), ("many",
        np.arange(len(triangles)))):
        words = read(freefem_text, write(tmp_path / f"{name}.mesh", points, triangles, sides, regions)).stdout.split("SIDES")[1]
        assert words.split()[:2] == [str(4 * N), "1"], name


def test_a_mesh_by_gmsh_that_is_folded_thin_or_no_number(tmp_path):
    starter = Starter(ROOT)
    try:
        def own(name, points, triangles, sides):
            return starter.run("own", "--from", write(tmp_path / f"{name}.msh", points, triangles, sides), "--out",
                tmp_path / f"{name}.mesh")
        done = own("fold", *moved((0.75, 0.58)))
        assert done.returncode == 4 and "lie on each other" in done.stderr and "mend it" in done.stderr, done.stderr
        points, triangles, sides = square()
        done = own("twice", points, np.concatenate([triangles, triangles[40:41, ::-1]]), sides)
        assert done.returncode == 4 and "lie on each other" in done.stderr, done.stderr
        done = own("nan", *moved((np.nan, 0.5)))
        assert done.returncode == 3 and "no finite number" in done.stderr, done.stderr
        points[:, 1] *= 0.02  # cells of 1 to 50: angles of 1.1 degrees
        done = own("layer", points, triangles, sides)
        assert done.returncode == 0 and "angle below 5 degrees" in done.stderr, done.stderr
        assert len(read_medit(tmp_path / "layer.mesh").triangles) == 2 * N * N
        assert not any((tmp_path / f"{name}.mesh").exists() for name in ("fold", "twice", "nan"))
    finally:
        starter.end()
