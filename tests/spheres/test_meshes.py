"""The default meshes of tetrahedra: sound, as the recipe makes them, and read by FreeFEM with their labels."""
import meshio
import numpy as np
import pytest

from tests.conftest import ROOT
from tools.meshing import CASES, space_mesh
from tools.meshing.main import make, parser

SPACE = [case for case, (recipe, _) in CASES.items() if recipe.__name__.startswith("tools.meshing.space_")]


def from_file(case):
    file = meshio.read(ROOT / "meshes" / f"{case}.mesh")
    return space_mesh.SpaceMesh(file.points, file.cells_dict["tetra"], file.cells_dict["triangle"],
        file.cell_data_dict["medit:ref"]["triangle"])


@pytest.mark.parametrize("case", SPACE)
def test_a_default_mesh_is_sound_and_is_what_the_recipe_makes(case):
    mesh, found = make(parser().parse_args([case, "--out", "unused.mesh"]))
    file = from_file(case)
    assert found == [] and space_mesh.faults(file) == []
    for one in (mesh, file):
        size = space_mesh.volumes(one.points, one.tetrahedra)
        assert size.min() > 0 and space_mesh.quality(one).min() > 0.2
        outer = {tuple(face) for face in np.sort(space_mesh.outer_faces(one.tetrahedra), axis=1).tolist()}
        assert outer == {tuple(face) for face in np.sort(one.triangles, axis=1).tolist()}
    assert len(file.points) == pytest.approx(len(mesh.points), rel=0.05)  # another machine's gmsh may place points otherwise
    assert (ROOT / "meshes" / f"{case}.mesh").stat().st_size < 2e6


def test_freefem_reads_the_default_meshes_with_their_labels(freefem_text):
    script = 'load "msh3"\ncout.precision(12);\n' + "".join(
        f'{{ mesh3 Th = readmesh3("meshes/{case}.mesh"); cout << "{case} " << Th.nv << " " << Th.nt << " " << Th.measure;'
        f' int[int] list = labels(Th); for (int i = 0; i < list.n; ++i) cout << " " << list[i] << " " << int2d(Th, list[i])(1.);'
        " cout << endl; }\n" for case in SPACE)
    printed = {line.split()[0]: line.split()[1:] for line in freefem_text(script).stdout.splitlines() if line}
    for case in SPACE:
        mesh, numbers = from_file(case), list(map(float, printed[case]))
        assert numbers[:2] == [len(mesh.points), len(mesh.tetrahedra)]
        assert numbers[2] == pytest.approx(space_mesh.volumes(mesh.points, mesh.tetrahedra).sum(), rel=1e-9)
        a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        assert dict(zip(numbers[3::2], numbers[4::2])) == pytest.approx(
            {label: area[mesh.labels == label].sum() for label in np.unique(mesh.labels)}, rel=1e-9)


def test_tetrahedra_that_lie_on_each_other_are_refused(freefem_text, tmp_path):
    """A vertex beyond its neighbours, and each tetrahedron turned to a positive volume: they were taken."""
    one = make(parser().parse_args(["settling_sphere", "--pattern", "grid", "--part", "whole", "--width", "1", "--height", "1",
        "--corridor", "1", "--corridor-top", "1", "--size", "0.25", "--out", "unused.mesh"]))[0]
    for to, status in (((0.05, 0.0, 0.5), 0), ((0.3, 0.3, 0.8), 3)):
        points, tetrahedra = one.points.copy(), one.tetrahedra.copy()
        points[np.argmin(np.linalg.norm(points - (0, 0, 0.5), axis=1))] = to
        back = space_mesh.volumes(points, tetrahedra) < 0
        tetrahedra[back] = tetrahedra[back][:, [1, 0, 2, 3]]
        space_mesh.write(space_mesh.SpaceMesh(points, tetrahedra, one.triangles, one.labels), tmp_path / "one.mesh")
        done = freefem_text(f'include "lib/spheres/read_mesh.idp"\nmesh3 Th = spaceRead("{tmp_path}/one.mesh");', check=False)
        assert done.returncode == status and ("lie on each other" in done.stderr) == (status == 3), done.stderr


def test_pieces_that_share_no_side_are_refused(freefem_text, tmp_path):
    """The run ended with a wrong pressure solver."""
    one = make(parser().parse_args(["sphere_array", "--size", "0.25", "--out", "unused.mesh"]))[0]
    n, edge = len(one.points), np.array([np.ptp(one.points[:, 0]), np.ptp(one.points[:, 1]), 0])
    two = space_mesh.SpaceMesh(np.concatenate([one.points, one.points + edge]),
        np.concatenate([one.tetrahedra, one.tetrahedra + n]), np.concatenate([one.triangles, one.triangles + n]),
        np.tile(one.labels, 2))
    assert "2 pieces" in space_mesh.faults(two)[0]
    space_mesh.write(two, tmp_path / "two.mesh")
    (tmp_path / "two.msh").write_text("$MeshFormat\n")
    (tmp_path / "bin.msh").write_bytes(b"$MeshFormat\n4.1 1 8\n\x01\0\0\0")  # of which it was said: no plain text
    for name, words in (("two.mesh", "is in pieces that share no side"), ("two.msh", "is one of gmsh; convert it"),
            ("bin.msh", "is one of gmsh; convert it")):
        done = freefem_text(f'include "lib/spheres/read_mesh.idp"\nmesh3 Th = spaceRead("{tmp_path}/{name}");', check=False)
        assert done.returncode == 3 and words in done.stderr, done.stderr
