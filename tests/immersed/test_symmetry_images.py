"""A scene with a plane of symmetry is half of the one that holds its mirror image too."""
import numpy as np
import pytest

from tests.conftest import run_freefem
from tests.scenes import case, square
from tools.base.mesh_files import read_mesh
from tools.base.run_folder import RunFolder
from tools.meshing.medit import write
from tools.meshing.plane_mesh import PlaneMesh

SWAP = {11: "labelLeft", 12: "labelRight", 13: "labelBottom", 14: "labelTop"}


def mirrored(half, plane):
    """The whole of a mesh of the unit square and its image beyond x = 0 (plane 11) or y = 1 (14); the far side of the image has the
    label 12 or 13."""
    axis, at = (0, 0.0) if plane == 11 else (1, 1.0)
    image = half.points.copy()
    image[:, axis] = 2 * at - image[:, axis]
    on = np.abs(half.points[:, axis] - at) < 1e-12
    place = np.where(on, np.arange(len(on)), len(on) + np.cumsum(~on) - 1)
    kept = half.labels != plane
    return PlaneMesh(np.vstack([half.points, image[~on]]), np.vstack([half.triangles, place[half.triangles[:, ::-1]]]),
                     np.vstack([half.edges[kept], place[half.edges[kept]]]), np.concatenate([half.labels[kept]] * 2))


# the plane across which the whole holds the image, other planes of symmetry of both, bodies of the half as (x, y, semi-axes, angle,
# density, velocity), gravity
SCENES = {
    "along": (11, [], [(0.17, 0.6, 0.14, 0.14, 0, 3.0, 0, 0), (0.6, 0.7, 0.13, 0.13, 0, 1.5, 0, 0)], -1),
    "an ellipse": (11, [], [(0.21, 0.6, 0.19, 0.14, 0.4, 3.0, 0, 0)], -1),
    "an ellipse that hits the plane": (11, [], [(0.4, 0.56, 0.22, 0.132, 0.6, 20.0, -1, -1)], 0),
    "a disk that hits the corner of two planes": (11, [14], [(0.4, 0.65, 0.2, 0.2, 0, 20.0, -1, 1)], 0),
    "an ellipse that hits the corner of two planes": (11, [14], [(0.4, 0.56, 0.22, 0.132, -0.6, 20.0, -1, 1)], 0),
}


@pytest.mark.parametrize("scene", SCENES)
def test_half_of_a_scene_moves_as_the_whole(scene, freefem_text, tmp_path):
    plane, others, bodies, gravity = SCENES[scene]
    script = tmp_path / "mesh.edp"
    script.write_text(square(tmp_path / "half.mesh", edges=14, sides=14))
    run_freefem(script)
    half = read_mesh(tmp_path / "half.mesh")
    write(mirrored(half, plane), tmp_path / "whole.mesh")
    places = []
    for name in ("half", "whole"):
        words = []
        for sign in (1, -1)[:1 + (name == "whole")]:
            for x, y, long, short, angle, density, u, v in bodies:
                words.append(f"{{ int d = bodyAdd({sign * x:.17g}, {y:.17g}, {long}, {density}, {sign * u}, {v}, 0, 1); bodyAspect[d] = {short / long:.17g}; bodyTheta[d] = {sign * angle}; }}")
        planes = others + [plane] * (name == "half")
        walls = [label for number, label in SWAP.items() if number not in (plane, *others)]
        text = case("{ " + " ".join(words) + " }", walls=", ".join(walls), slip=", ".join(SWAP[k] for k in planes), gravity=gravity)
        freefem_text(text, "-mesh", tmp_path / f"{name}.mesh", "-tend", 0.6, "-every", 0, "-cfl", 0, "-tolerance", 1e-12, "-out",
            tmp_path / name)
        rows = RunFolder(tmp_path / name).particles
        mine = rows["id"] < len(bodies)
        places.append(np.column_stack([rows[column][mine] for column in ("x", "y", "theta", "u", "v", "omega")]))
    assert np.abs(places[0] - places[1]).max() < 1e-9  # 0.01 where points beyond the plane are not mirrored
