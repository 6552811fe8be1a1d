"""Meshes: every recipe, the default files, what FreeFEM makes of them, and refusals."""
import re

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tests.conftest import ROOT, run_tool
from tests.tables import read_medit
from tools.base.command import BadInput
from tools.meshing import CASES
from tools.meshing.checks import faults
from tools.meshing.labels import LABELS
from tools.meshing.main import make, parser
from tools.meshing.plane_mesh import edges_of, signed_areas, smallest_angles

PLANE = [case for case, (recipe, _) in CASES.items() if not recipe.__name__.startswith("tools.meshing.space_")]
UNSTRUCTURED = ["channel", "box", "box_corridor", "periodic_box", "couette"]
BUILT = {}  # outline and mesh of recipe and options


def built(*words):
    """The outline and the mesh of the command line words, as python -m tools.mesh makes them."""
    options = parser().parse_args([*map(str, words), "--out", "unused.mesh"])
    recipe = CASES[options.case][0]
    options.case = ""  # several cases have one recipe; with the same options it makes the same mesh
    given = recipe, repr(sorted(vars(options).items()))
    if given not in BUILT:
        BUILT[given] = recipe.build(options)
    return BUILT[given]


def command(*words):
    return run_tool("mesh", *words)


def corner_triangles(mesh):
    """Number of triangles with two edges on the boundary."""
    edges, count = edges_of(mesh.triangles)
    boundary = set(map(tuple, np.sort(edges[count == 1], axis=1).tolist()))
    on_it = [[tuple(pair) in boundary for pair in np.sort(mesh.triangles[:, corners], axis=1).tolist()] for corners in ((0, 1),
        (1, 2), (2, 0))]
    return int((np.sum(on_it, axis=0) > 1).sum())


@pytest.mark.parametrize("case", PLANE)
def test_default_mesh_is_sound_and_is_what_the_recipe_makes(case):
    outline, mesh = built(case)
    file = read_medit(ROOT / "meshes" / f"{case}.mesh")
    for one in (mesh, file):
        assert faults(one, outline) == []
        assert corner_triangles(one) == 0
    # Another machine's gmsh may place a few points otherwise.
    assert len(file.points) == pytest.approx(len(mesh.points), rel=0.02)


@pytest.mark.parametrize("case", UNSTRUCTURED)
def test_unstructured_pattern(case):
    outline, mesh = built(case, "--pattern", "unstructured")
    assert faults(mesh, outline) == []
    assert smallest_angles(mesh.points, mesh.triangles).min() > 25


def test_freefem_reads_every_default_mesh_with_its_labels(freefem_text):
    script = "".join(
        f'{{ mesh Th = readmesh("meshes/{case}.mesh"); cout << "{case} " << Th.nv << " " << Th.nt << " " << Th.area;'
        f' int[int] list = labels(Th); for (int i = 0; i < list.n; ++i) cout << " " << list[i] << " " << int1d(Th, list[i])(1.);'
        " cout << endl; }\n"
        for case in PLANE
    )
    printed = {line.split()[0]: line.split()[1:] for line in freefem_text("cout.precision(12);\n" + script).stdout.splitlines()
        if line}
    for case in PLANE:
        mesh = read_medit(ROOT / "meshes" / f"{case}.mesh")
        numbers = list(map(float, printed[case]))
        assert numbers[:2] == [len(mesh.points), len(mesh.triangles)]
        assert numbers[2] == pytest.approx(signed_areas(mesh.points, mesh.triangles).sum(), rel=1e-9)
        lengths = dict(zip(numbers[3::2], numbers[4::2]))
        own = np.linalg.norm(np.diff(mesh.points[mesh.edges], axis=1)[:, 0], axis=1)
        assert lengths == pytest.approx({k: own[mesh.edge_labels == k].sum() for k in np.unique(mesh.edge_labels)}, rel=1e-9)


@pytest.mark.parametrize("pattern", ["right", "alternating", "unstructured"])
@pytest.mark.parametrize("case", ["periodic_box", "couette"])
def test_freefem_finds_matching_nodes_on_periodic_sides(case, pattern, freefem_text, tmp_path):
    file = tmp_path / "box.mesh"
    assert command(case, "--pattern", pattern, "--size", 0.1, "--out", file).returncode == 0
    sides = "[11, y], [12, y]" + (", [13, x], [14, x]" if case == "periodic_box" else "")
    printed = freefem_text(
        f'mesh Th = readmesh("{file}"); fespace Free(Th, P1); fespace Periodic(Th, P1, periodic = [{sides}]);\n'
        'cout << "lost " << Free.ndof - Periodic.ndof << endl;'
    ).stdout
    lost = int(re.search(r"lost (\d+)", printed).group(1))
    assert lost == (21 if case == "periodic_box" else 11)


def sizes_at(mesh, points):
    """Longest edge of the triangle whose centre is nearest to each point."""
    corners = mesh.points[mesh.triangles]
    longest = np.max([np.linalg.norm(corners[:, i] - corners[:, j], axis=1) for i, j in ((0, 1), (1, 2), (2, 0))], axis=0)
    centres = corners.mean(axis=1)
    return [longest[np.argmin(np.linalg.norm(centres - point, axis=1))] for point in np.array(points)]


def test_pipe_is_finer_at_walls_in_throats_and_in_shear_layers():
    _, mesh = built("pipe_obstacles", "--size", 0.01, "--wall-factor", 0.4, "--throat-factor", 0.4, "--layer-factor", 0.5)
    bulk, wall, throat, throat2, layer = sizes_at(mesh, [(0.15, 0), (0.15, 0.1), (0.3, 0), (0.6, 0), (0.4, 0.05)])
    assert 0.008 < bulk < 0.0135
    assert wall < 0.006 and throat < 0.006 and throat2 < 0.006 and layer < 0.0075


def test_pipe_dimensions_are_options():
    outline, mesh = built(
        "pipe_obstacles", "--radius", 0.2, "--length", 2, "--size", 0.04, "--diaphragm-position", 1.2, "--diaphragm-opening", 0.1,
        "--obstacle-position", 0.5, "--obstacle-base", 0.3, "--obstacle-height", 0.1,
    )  # fmt: skip
    assert faults(mesh, outline) == []
    assert outline.area() == pytest.approx(2 * 0.4 - 2 * 0.01 * 0.15 - 0.3 * 0.1)
    assert outline.lengths()[LABELS["diaphragm"]] == pytest.approx(2 * (2 * 0.15 + 0.01))
    assert outline.lengths()[LABELS["obstacle"]] == pytest.approx(4 * np.hypot(0.15, 0.1))


@pytest.mark.parametrize("left_out, label", [("--no-diaphragm", "diaphragm"), ("--no-obstacle", "obstacle")])
def test_pipe_without_one_of_its_bodies(left_out, label):
    outline, mesh = built("pipe_obstacles", "--size", 0.02, left_out)
    assert faults(mesh, outline) == []
    assert LABELS[label] not in mesh.edge_labels


@pytest.mark.parametrize("points", [16, 48])
def test_polygon_of_the_cylinder(points):
    outline, mesh = built("cylinder_channel", "--circle-points", points)
    assert np.sum(mesh.edge_labels == LABELS["cylinder"]) == points
    # the area of the circle less what the waves of the polygon add to its drag
    orders, angles = np.arange(1, 40), ((np.arange(4000) + 0.5) / 2000 - 1) * np.pi / points
    distance = 1 / np.cos(angles)  # of a side from the centre
    waves = 2 * np.mean(distance * np.cos(np.outer(orders * points, angles)), axis=1) / distance.mean()
    area = 2.2 * 0.41 - signed_areas(mesh.points, mesh.triangles).sum()
    assert 0.5 * (1 - area / (np.pi * 0.05**2)) == pytest.approx(np.sum(orders * points * waves**2), rel=0.05)
    around = sizes_at(mesh, [(0.255, 0.2)])[0]
    wake, far = sizes_at(mesh, [(0.4, 0.2), (1.9, 0.35)])
    assert wake < far
    if points >= 32:  # with fewer the circle itself is coarser than its wake
        assert around < wake


def test_sudden_expansion_is_symmetric():
    _, mesh = built("sudden_expansion")
    places = {tuple(point) for point in np.round(mesh.points, 10).tolist()}
    assert places == {(x, 0.0 if y == 0 else -y) for x, y in places}
    centres = {tuple(c) for c in np.round(mesh.points[mesh.triangles].mean(axis=1), 8).tolist()}
    assert centres == {(x, -y) for x, y in centres}


def test_half_of_the_expansion_has_an_axis():
    outline, mesh = built("sudden_expansion", "--half")
    assert faults(mesh, outline) == []
    assert outline.lengths()[LABELS["axis"]] == pytest.approx(43)


def test_step_without_inlet_channel():
    outline, mesh = built("backward_step", "--inlet-length", 0)
    assert faults(mesh, outline) == []
    assert outline.lengths()[LABELS["inlet"]] == pytest.approx(1)


def test_corridor_is_uniform_and_fine():
    _, mesh = built("settling_disk", "--size", 0.125)
    _, corridor = built("box_corridor", "--size", 0.05)
    inside, flank = sizes_at(corridor, [(1.0, 3.0), (0.1, 3.0)])
    assert inside == pytest.approx(0.05 * np.sqrt(2), rel=0.1) and flank > 1.5 * inside
    assert len(mesh.points) == 17 * 49
    for pattern in ("right", "unstructured"):
        outline, short = built("box_corridor", "--size", 0.05, "--corridor-bottom", 2, "--corridor-top", 4, "--pattern", pattern)
        assert faults(short, outline) == [] and len(short.points) < 0.75 * len(built("box_corridor", "--size", 0.05, "--pattern",
            pattern)[1].points)
        inside, below, above = sizes_at(short, [(1.0, 3.0), (1.0, 0.3), (1.0, 5.7)])
        assert min(below, above) > 1.5 * inside


def test_a_stream_is_fine_where_a_body_moves_little():
    """The path of the body's centre may be shorter than an element."""
    for stroke in (0.01, 0.05, 0.2):
        _, mesh = built("sprung_cylinder", "--stroke", stroke)
        assert sizes_at(mesh, [(6.0, 6.0)])[0] < 0.11


@settings(max_examples=15, deadline=None)
@given(
    position=st.floats(0.0, 1.0), thickness=st.floats(0.002, 0.1), opening=st.floats(0.001, 0.25),
    triangle=st.floats(0.0, 1.0), base=st.floats(0.01, 0.5), height=st.floats(0.005, 0.12),
)  # fmt: skip
def test_any_pipe_is_sound_or_refused(position, thickness, opening, triangle, base, height):
    words = [
        "pipe_obstacles", "--size", 0.02, "--diaphragm-position", position, "--diaphragm-thickness", thickness,
            "--diaphragm-opening",
        opening, "--obstacle-position", triangle, "--obstacle-base", base, "--obstacle-height", height,
    ]  # fmt: skip
    try:
        outline, mesh = built(*words)
    except BadInput as refusal:
        assert str(refusal)
    else:
        slivers = [fault for fault in faults(mesh, outline) if "angle" in fault]
        assert faults(mesh, outline) == slivers  # a thin corner of the domain itself is told, not written


BAD = [
    (["pipe_obstacles", "--diaphragm-opening", 0], "the diaphragm is closed"),
    (["pipe_obstacles", "--diaphragm-opening", 0.2], "must be smaller than the pipe"),
    (["pipe_obstacles", "--diaphragm-position", 0.58], "overlap"),
    (["pipe_obstacles", "--diaphragm-position", 0.5449999], "far shorter than the elements"),
    (["pipe_obstacles", "--diaphragm-position", 0], "not within the pipe"),
    (["pipe_obstacles", "--obstacle-position", 0.99], "not within the pipe"),
    (["pipe_obstacles", "--obstacle-height", 0.1], "the obstacles meet"),
    (["pipe_obstacles", "--size", 0.11], "larger than half the height"),
    (["pipe_obstacles", "--diaphragm-opening", 0.01, "--size", 0.02], "larger than the throat of the diaphragm"),
    (["pipe_obstacles", "--obstacle-height", 0.097, "--size", 0.01], "larger than the throat between the obstacles"),
    (["pipe_obstacles", "--size", -1], "must be positive"),
    (["pipe_obstacles", "--size", "nan"], "not a finite number"),
    (["pipe_obstacles", "--size", "small"], "not a number"),
    (["pipe_obstacles", "--size", 1e-6], "vertices"),
    (["pipe_obstacles", "--wall-factor", 2], "at most 1"),
    (["pipe_obstacles", "--sise", 0.01], "--sise"),
    (["pipe_obstacle"], "invalid choice"),
    (["cylinder_channel", "--radius", 0.3], "not within the channel"),
    (["cylinder_channel", "--circle-points", 3], "between"),
    (["cylinder_channel", "--size", 0.3], "larger than half the height"),
    (["box", "--size", 3], "too large"),
    (["box_corridor", "--corridor-width", 3], "not within the box"),
    (["box_corridor", "--corridor-bottom", 5, "--corridor-top", 4], "not upwards within the box"),
    (["box_corridor", "--corridor-top", 7], "not upwards within the box"),
    (["sprung_cylinder", "--stroke", 5.5], "not within 20 x 12"),
    (["sprung_cylinder", "--size", 0.5], "too large for the place of the body"),
    (["sprung_cylinder", "--coarse-factor", 0.5], "at least 1"),
    (["cavity", "--size", 1e-7], "vertices"),
    (["backward_step", "--stretch", 0.97], "must be at least 1"),
    (["sudden_expansion", "--stretch", 0.97], "must be at least 1"),
    (["cavity", "--size", 1e-30], "vertices"),  # refused by its number, before any array
    *(([case, "--size", size], "between 1e-30 and 1e+30") for case in ("cavity", "pipe_obstacles") for size in (1e-300, 1e300)),
    (["pipe_obstacles", "--throat-factor", 1e-300], "between 1e-30 and 1e+30"),
    (["pipe_obstacles", "--length", 1e300], "between 1e-30 and 1e+30"),
    (["pipe_obstacles", "--obstacle-base", 1e-30], "far shorter than the elements"),  # gmsh searched for ever
    (["box_corridor", "--height", 1e-30], "too large for the height of the box"),
    (["cylinder_channel", "--radius", 1e-30], "corners are one point"),
    (["sprung_cylinder", "--coarse-factor", 1e30], "too large for a side"),
    *(([case, "--size", 1e-15], "vertices") for case in ("box", "box_corridor", "backward_step", "sudden_expansion", "couette",
        "sprung_cylinder")),
    *(([case, "--size", 1e-6], "tetrahedra") for case in ("pipe_spheres", "settling_sphere", "held_sphere", "sphere_array")),
    (["two_spheres", "--pattern", "grid", "--size", 1e-3], "tetrahedra"),
    (["settling_sphere", "--coarse", 0], "must be positive"),  # a division by 0
    (["held_sphere", "--coarse", "nan"], "not a finite number"),  # 33 vertices
    (["backward_step", "--size", 1], "too large"),
    (["sudden_expansion", "--ratio", 1], "larger than 1"),
]


def test_a_box_of_nanometres_has_the_cells_of_one_of_units():
    """Grid points were rounded to the 14th decimal, which is the third digit of such a cell."""
    words = {"--width": 2, "--height": 6, "--corridor-position": 1, "--corridor-width": 0.75, "--size": 1 / 16}
    (_, one), (_, tiny) = (built("box_corridor", *(word for name, value in words.items() for word in (name, unit * value)))
        for unit in (1, 1e-9))
    np.testing.assert_allclose(tiny.points * 1e9, one.points, rtol=0, atol=1e-12)


@pytest.mark.parametrize("words, complaint", BAD, ids=lambda value: " ".join(map(str, value)) if isinstance(value, list) else "")
def test_bad_parameters_are_refused_in_one_line(words, complaint, tmp_path):
    file = tmp_path / "bad.mesh"
    run = command(*words, "--out", file)
    assert run.returncode == 3
    assert len(run.stderr.splitlines()) == 1 and run.stderr.startswith("error: ") and complaint in run.stderr
    assert not list(tmp_path.iterdir())


def test_a_file_that_cannot_be_written(tmp_path):
    (tmp_path / "in_the_way").write_text("")
    run = command("channel", "--out", tmp_path / "in_the_way" / "a.mesh")
    assert run.returncode == 3 and "cannot write" in run.stderr and len(run.stderr.splitlines()) == 1


def test_the_old_file_is_replaced_and_nothing_else_is_left(tmp_path):
    file = tmp_path / "new folder" / "a.mesh"
    for size in (0.5, 0.25):
        assert command("channel", "--size", size, "--out", file).returncode == 0
    assert [path.name for path in file.parent.iterdir()] == ["a.mesh"]
    assert len(read_medit(file).points) == 17 * 5


def test_quality_prints_a_histogram(tmp_path):
    run = command("channel", "--quality", "--out", tmp_path / "a.mesh")
    assert "45-50" in run.stdout and "2048 ####" in run.stdout


@pytest.mark.parametrize("fault, words", [
    ("inverted", "inverted"), ("sliver", "angle"), ("lost triangle", "cover"), ("lost edge", "not the boundary edges"),
    ("wrong label", "sum to"), ("no label", "on no side"), ("loose vertex", "no triangle"), ("not finite", "finite"),
])  # fmt: skip
def test_faults_are_found(fault, words):
    outline, mesh = built("channel", "--size", 0.25)
    if fault == "inverted":
        mesh.triangles[7] = mesh.triangles[7][::-1]
    elif fault == "sliver":
        inner = np.setdiff1d(mesh.triangles, mesh.edges)[0]
        triangle = mesh.triangles[np.any(mesh.triangles == inner, axis=1)][0]
        a, b = mesh.points[triangle[triangle != inner]]
        mesh.points[inner] = 0.5 * (a + b) + 1e-3 * (mesh.points[inner] - 0.5 * (a + b))
    elif fault == "lost triangle":
        mesh.triangles = mesh.triangles[1:]
    elif fault == "lost edge":
        mesh.edges, mesh.edge_labels = mesh.edges[1:], mesh.edge_labels[1:]
    elif fault == "wrong label":
        mesh.edge_labels[0] = LABELS["wall"]
    elif fault == "no label":
        mesh.edge_labels[0] = 0
    elif fault == "loose vertex":
        mesh.points = np.vstack([mesh.points, [0.1, 0.1]])
    elif fault == "not finite":
        mesh.points[3, 0] = np.nan
    assert any(words in sentence for sentence in faults(mesh, outline)), faults(mesh, outline)


def test_default_meshes_command_knows_its_names():
    run = run_tool("default_meshes", "nonsense")
    assert run.returncode == 3 and "no default mesh is named" in run.stderr


def test_make_returns_no_fault():
    mesh, found = make(parser().parse_args(["channel", "--out", "unused.mesh"]))
    assert found == [] and len(mesh.points) == 65 * 17


def test_what_is_no_mesh_is_not_written_over(tmp_path):
    note = tmp_path / "note.mesh"
    note.write_text("precious")
    for name, complaint in ((note, "is no mesh"), (tmp_path / "README.md", "ends with .mesh"), (tmp_path / "my box.mesh",
        "without spaces")):
        run = command("box", "--size", 0.5, "--out", name)
        assert run.returncode == 3 and complaint in run.stderr and len(run.stderr.splitlines()) == 1
    assert note.read_text() == "precious" and [file.name for file in tmp_path.iterdir()] == ["note.mesh"]
    assert command("box", "--size", 0.5, "--out", tmp_path / "box.mesh").returncode == 0 == command("box", "--size", 0.4, "--out",
        tmp_path / "box.mesh").returncode


def test_the_template_runs_on_the_mesh_of_its_header(freefem, tmp_path):
    lines = re.findall(r"^//   (.*)$", (ROOT / "cases" / "template.edp").read_text(), re.MULTILINE)
    file = tmp_path / "my.mesh"
    make_it, run_it = ([str(file) if word == "results/my.mesh" else word for word in line.split()] for line in lines
        if "results/my.mesh" in line)
    assert make_it[:3] == ["python", "-m", "tools.mesh"] and run_it[:2] == ["FreeFem++", "-nw"]
    assert command(*make_it[3:]).returncode == 0
    freefem(*run_it[2:], "-tend", 0.005, "-out", tmp_path / "run")
    assert np.ptp(read_medit(tmp_path / "run" / "mesh.mesh").points[:, 0]) == pytest.approx(3)
