"""Runs of spheres in three dimensions, as the tools read, cut and draw them."""
import json

import meshio
import numpy as np
import pytest

from tests.conftest import run_freefem, run_tool
from tests.synthetic import write_csv
from tools.base import quantities
from tools.base.command import BadInput
from tools.base.expressions import unit_of
from tools.base.run_folder import RunFolder
from tools.base.space_mesh import Section, SpaceMesh, dimension_of, read_space_mesh
from tools.plot import film, resolved as plot, series as time_series
from tools.plot.in_time import FieldsInTime, film_times
from tools.plot.colour import Look
from tools.plot.sphere_bodies import unit_sphere
from tools.plot.spheres import SphereRun, plane_of
from tools.plot.style import plt
from tools.study.study import same_mesh, true_sizes

ORDERS = [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]  # of the steps along a cell: six tetrahedra
LABELS = {(0, 0): 11, (0, 1): 12, (1, 0): 15, (1, 1): 16, (2, 0): 13, (2, 1): 14}


def block(n, sides=(1.0, 1.0, 1.0), moved=0.0):
    """A SpaceMesh of a block of n^3 cells from the origin, six tetrahedra each; its inner vertices are moved by up to `moved` of a
    cell."""
    number = np.arange((n + 1)**3).reshape(n + 1, n + 1, n + 1)
    points = np.stack(np.meshgrid(*[np.linspace(0, side, n + 1) for side in sides], indexing="ij"), axis=-1).reshape(-1, 3)
    inner = np.all((points > 1e-9) & (points < np.array(sides) - 1e-9), axis=1)
    points[inner] += moved * np.random.default_rng(1).uniform(-1, 1, (inner.sum(), 3)) * np.array(sides) / n
    cells = []
    for order in ORDERS:
        corner, path = np.zeros(3, int), []
        for axis in (None, *order):
            corner = corner + (np.arange(3) == axis if axis is not None else 0)
            path.append(number[tuple(slice(c, n + c) for c in corner)].ravel())
        cells.append(np.stack(path, axis=1))
    tetrahedra = np.concatenate(cells)
    faces = np.concatenate([np.delete(tetrahedra, k, axis=1) for k in range(4)])
    found, labels = [], []
    for (axis, end), label in LABELS.items():
        there = np.all(abs(points[faces][:, :, axis] - end * sides[axis]) < 1e-9, axis=1)
        found.append(faces[there])
        labels += [label] * there.sum()
    return SpaceMesh(points, tetrahedra, np.concatenate(found), np.array(labels))


def write_medit(path, mesh):
    """A SpaceMesh as a .mesh file."""
    rows = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", len(mesh.points), *(" ".join(f"{c:.15g}" for c in p) + " 0"
        for p in mesh.points), "Triangles", len(mesh.triangles), *(" ".join(map(str, [*(t + 1), label]))
        for t, label in zip(mesh.triangles, mesh.labels)), "Tetrahedra", len(mesh.tetrahedra), *(" ".join(map(str, [*(t + 1), 0]))
        for t in mesh.tetrahedra), "End"]
    path.write_text("\n".join(map(str, rows)) + "\n")


def areas(mesh):
    """Areas of the triangles of a plane Mesh."""
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    (u, v), (p, q) = (b - a).T, (c - a).T
    return 0.5 * abs(u * q - v * p)


NAMES = "step,t,id,x,y,z,u,v,w,omega_x,omega_y,omega_z,radius".split(",")


@pytest.fixture(scope="module")
def space(tmp_path_factory):
    """A made-up run in a block of 1 by 1 by 2: one sphere that falls at the edge x = y = 0, where two planes of symmetry meet, one
    that stays beside it, until it leaves."""
    folder = tmp_path_factory.mktemp("space") / "run"
    folder.mkdir()
    mesh = block(4, (1, 1, 2))
    write_medit(folder / "mesh.mesh", mesh)
    listed, particles, fluid = "", [], []
    for k in range(5):
        t = 0.25 * k
        velocity = np.column_stack([0 * mesh.points[:, 0], t * mesh.points[:, 0], -t * (2 - mesh.points[:, 0])])
        cells = [("tetra", mesh.tetrahedra), ("triangle", mesh.triangles)]
        meshio.write(folder / f"fields_{k}.vtu", meshio.Mesh(mesh.points, cells,
            point_data={"velocity": velocity, "pressure": mesh.points[:, 2]}))
        listed += f'<DataSet timestep="{t}" file="fields_{k}.vtu"/>'
        fluid.append([k, t, 0.25, 0.1 * t, 1e-3, 2 * t + 0.1, 2 - (k == 4), 1, 1e30])
        particles.append([k, t, 7, 0, 0, 1.5 - t, 0, 0, -1, 0, 0, 0, 0.2])
        if k < 4:
            particles.append([k, t, 9, 0.7, 0.3, 1.0, 3, 4, 12, 1, 2, 2, 0.25])
    (folder / "fields.pvd").write_text(f'<VTKFile type="Collection"><Collection>{listed}</Collection></VTKFile>')
    write_csv(folder / "particles.csv", NAMES, particles)
    write_csv(folder / "fluid.csv", "step,t,dt,kinetic_energy,divergence,top_speed,particles,contacts,worst_gap".split(","), fluid)
    write_csv(folder / "contacts.csv", "t,i,j,gap,nx,ny,nz,impulse".split(","), [[0.25, 7, 9, 0.05, -0.6, 0, 0.8, 0.5],
        [0.25, 9, -4, 0.01, 0, 1, 0, 0.25]])
    (folder / "run.json").write_text(json.dumps({"case": "made_up", "status": "finished", "open": [11, 15], "parameters": {},
        "units": {"-radius": "m"}}))
    return folder


@pytest.mark.parametrize("moved", [0, 0.3])
@pytest.mark.parametrize("axis, at", [(0, 0), (0, 1), (1, 0.5), (1, 0.31), (2, 1.0), (2, 1.17), (2, 2), (0, 0.25 + 1e-12)])
def test_a_section_covers_the_plane_once_and_keeps_linear_fields(axis, at, moved):
    sides = 1, 1, 2
    mesh = block(4, sides, moved)
    cut = Section(mesh, axis, at)
    across = [k for k in range(3) if k != axis]
    assert areas(cut.mesh).sum() == pytest.approx(np.prod([sides[k] for k in across]), rel=1e-12)
    assert areas(cut.mesh).min() > 0 and np.all(np.diff(areas(cut.mesh)) > -1e-12)
    linear = mesh.points @ [[1, 5], [2, 6], [3, 7]]
    exact = np.zeros((len(cut.mesh.points), 3))
    exact[:, across], exact[:, axis] = cut.mesh.points, at
    assert np.allclose(cut.of(linear), exact @ [[1, 5], [2, 6], [3, 7]], atol=1e-9)
    assert len(np.unique(cut.mesh.points, axis=0)) == len(cut.mesh.points)
    ends = cut.mesh.points[cut.mesh.edges]
    for k, along in enumerate(across):
        for end in (0, 1):
            own = ends[cut.mesh.labels == LABELS[along, end]]
            assert np.allclose(own[:, :, k], end * sides[along])
            assert np.linalg.norm(own[:, 1] - own[:, 0], axis=1).sum() == pytest.approx(sides[across[1 - k]])
    assert LABELS[axis, 0] not in cut.mesh.labels and LABELS[axis, 1] not in cut.mesh.labels


@pytest.mark.parametrize("at", [-0.1, 1.1])
def test_a_plane_beside_the_mesh_is_refused(at):
    with pytest.raises(BadInput, match="does not meet the mesh, which lies between 0 and 1"):
        Section(block(2), 1, at)


def test_a_run_of_spheres_is_read(space, run):
    assert not run.in_space and len(run.extent) == 4
    found = RunFolder(space)
    assert found.in_space and found.extent == (0, 0, 0, 1, 1, 2) and found.mesh.tetrahedra.shape == (384, 4)
    mesh, values = found.field(2)
    assert values["velocity"].shape == (125, 3) and values["pressure"].shape == (125,) and mesh.tetrahedra.shape == (384, 4)
    assert np.allclose(found.particles_at(0.375), [[7, 9], [0, 0.7], [0, 0.3], [1.125, 1.0], [0.2, 0.25]])
    assert found.particles_at(1.0).shape == (5, 1)  # the other has left
    assert found.units_per_depth == {"speed": "m/s", "pressure": "Pa", "force": "N", "energy": "J"}
    assert [unit_of(text, found) for text in ("particles.csv:z:last", "particles.csv:omega_y:last", "fluid.csv:kinetic_energy:max",
        "contacts.csv:impulse:max", "fluid.csv:flux_in:max")] == ["m", "1/s", "J", "N s", "m$^3$/s"]
    for name, value in (("mean_w", -1), ("final_z", 0.5), ("peak_speed", 1), ("peak_speed:9", 13), ("worst_overlap", 0)):
        assert quantities.evaluate(quantities.parse(name, quantities.load()), found) == (pytest.approx(value), "")
    assert "no column omega; it has step" in quantities.evaluate(quantities.parse("mean_omega", quantities.load()), found)[1]


@pytest.mark.parametrize("cut, put", [("Tetrahedra", "Hexahedra"), (" 125 ", " 126 "), ("Tetrahedra\n384", "Tetrahedra\n385")])
def test_a_damaged_mesh_is_refused(space, tmp_path, cut, put):
    text = (space / "mesh.mesh").read_text()
    assert cut in text
    (tmp_path / "m.mesh").write_text(text.replace(cut, put))
    with pytest.raises(BadInput, match="m.mesh is not a whole"):
        read_space_mesh(tmp_path / "m.mesh")
    assert dimension_of(tmp_path / "m.mesh") == 3 and dimension_of(tmp_path / "none.mesh") == 0


def test_the_usual_plane_cuts_a_sphere(space):
    seen = SphereRun(space)
    assert (seen.axis, seen.at) == (1, 0.5)  # through the second one
    assert (SphereRun(space, plane_of("x=0.25")).axis, SphereRun(space, plane_of(" z = 1e0 ")).at) == (0, 1.0)
    seen.__dict__["particles"] = {name: column[seen.particles["id"] == 7] for name, column in seen.particles.items()}
    assert seen.usual_plane() == (1, 0.0)


@pytest.mark.parametrize("text", ["y", "y=", "w=1", "y=nan", "0.1", "xy=1"])
def test_a_plane_is_a_name_and_a_number(text):
    with pytest.raises(BadInput, match="--plane needs x, y or z and a position"):
        plane_of(text)


def test_circles_are_those_in_which_the_plane_cuts_the_spheres(space):
    """The plane is y = 0.15, 0.15 from either centre: r^2 - 0.0225; the images are those at the sides x = 0 and y = 0."""
    seen = SphereRun(space, (1, 0.15))
    assert seen.mirrors == {0: 0.0, 1: 0.0} and seen.extent == (-1, 0, 2, 2)
    figure, axes = plt.subplots()
    cut, behind_or_front = seen.draw_particles(axes, 0.0)[0], seen.draw_particles(axes, 0.0)[1:]
    boxes = np.array([path.get_extents().bounds for path in cut.get_paths()])
    order = np.argsort(boxes[:, 0])
    assert np.allclose(boxes[order, 2] / 2, np.sqrt([0.0625 - 0.0225, 0.04 - 0.0225, 0.0625 - 0.0225]))
    assert np.allclose(boxes[order, 0] + boxes[order, 2] / 2, [-0.7, 0, 0.7])
    front, behind = (sorted(path.get_extents().width / 2 for path in one.get_paths()) for one in behind_or_front)
    assert np.allclose(front, [0.2]) and np.allclose(behind, [0.25, 0.25])  # y grows away from the viewer
    faces = seen.draw_particles(axes, 0.0, Look(seen, "size"))[0].get_facecolor()
    assert len(np.unique(faces[order], axis=0)) == 2 and np.array_equal(faces[order][0], faces[order][2])
    plt.close(figure)


def test_fields_are_mirrored_with_their_domain(space):
    mesh, values = SphereRun(space).field(4)
    assert areas(mesh).sum() == pytest.approx(4)
    x = mesh.points[:, 0]
    assert np.allclose(values["velocity"], np.column_stack([0 * x, abs(x), abs(x) - 2])) and np.allclose(values["pressure"],
        mesh.points[:, 1])
    outline = SphereRun(space).mesh
    assert set(outline.labels) == {12, 13, 14}  # nothing at x = 0


def test_pictures_of_spheres_are_made(space, tmp_path, capsys):
    assert plot.main([str(space), "--out", str(tmp_path), "--gif", "--frames", "2"]) == 0
    said = capsys.readouterr().out
    assert said.count("left out") == 1 and "chains: left out, the run is in three dimensions" in said
    for name in ("fields.png", "trajectories.png", "series.png"):
        picture = plt.imread(tmp_path / name)
        assert picture.shape[1] > 600 and picture[:, :, :3].std() > 0.02
    assert (tmp_path / "film.gif").stat().st_size > 2000


def test_what_is_drawn_of_spheres(space, tmp_path, monkeypatch):
    drawn = []
    for module in (plot, plot.spheres, time_series):
        monkeypatch.setattr(module, "save", lambda figure, path: drawn.append(figure))
    seen = SphereRun(space)
    plot.plot_fields(seen, None, number=1)
    plot.spheres.plot_trajectories(seen, None)
    plot.plot_series(seen, None)
    fields, paths, series = drawn
    assert fields.texts[0].get_text() == "made up, y = 0.5 m: velocity and spheres"
    assert (fields.axes[0].get_xlabel(), fields.axes[0].get_ylabel()) == ("x (m)", "z (m)")
    assert [(one.get_xlabel(), one.get_ylabel()) for one in paths.axes] == [("x (m)", "z (m)"), ("y (m)", "z (m)")]
    assert [len(one.patches) for one in paths.axes] == [1, 1]  # one has left
    labels = [one.get_ylabel() for one in series.axes]
    assert labels == ["z (m)", "speed of the spheres\n(m/s)", "angular speed\n(1/s)", "kinetic energy (J)", "number",
        "norm of div u /\nlargest speed"]
    assert np.allclose(series.axes[1].lines[1].get_ydata(), 13) and np.allclose(series.axes[2].lines[1].get_ydata(), 3)
    for figure in drawn:
        plt.close(figure)


def test_the_film_cuts_a_mesh_once(space, monkeypatch):
    made = []
    monkeypatch.setattr(plot.spheres, "Section", lambda *given: made.append(given) or Section(*given))
    seen = SphereRun(space)
    assert len(list(film.pictures(seen, film_times(seen)[:3]))) == 3
    assert len(made) == 2  # one of the outline, one of the fields


def test_fields_of_a_plane_are_linear_in_time(space, tmp_path, capsys):
    mesh, values = FieldsInTime(SphereRun(space)).at(0.6)
    x = mesh.points[:, 0]
    assert np.allclose(values["velocity"], 0.6 * np.column_stack([0 * x, abs(x), abs(x) - 2]))
    assert plot.main([str(space), "--times", "0.6", "0.9", "--only", "fields", "outlines", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "outlines: left out, the run is in three dimensions" in said and (tmp_path / "fields.png").stat().st_size > 10_000


def test_spheres_as_arrays(space):
    run = RunFolder(space)
    assert run.bodies.id.tolist() == [7, 9] and run.bodies.z[:, 0] == pytest.approx(1.5 - run.bodies.t)
    assert np.isnan(run.bodies.omega_z).tolist() == [[False, False]] * 4 + [[False, True]]
    times, velocity = run.over_time("velocity")
    assert velocity.shape == (5, 125, 3) and np.allclose(velocity[:, :, 2], -times[:, None] * (2 - run.mesh.points[:, 0]))
    times, velocity = SphereRun(space).over_time("velocity")
    assert velocity.shape == (5, len(SphereRun(space).field(0)[0].points), 3)


def test_spheres_as_a_grid(space):
    pytest.importorskip("pyvista")
    grid = RunFolder(space).grid()
    assert grid.n_points == 125 and grid["velocity"].shape == (125, 3) and grid.bounds[5] == 2


def test_fixed_spheres_have_no_paths(space, tmp_path, capsys):
    (tmp_path / "mesh.mesh").write_bytes((space / "mesh.mesh").read_bytes())
    write_csv(tmp_path / "particles.csv", NAMES, [[k, k, 1, 0.5, 0.5, 1, 0, 0, 0, 0, 0, 0, 0.2] for k in range(3)])
    write_csv(tmp_path / "fluid.csv", ["t", "kinetic_energy", "particles", "contacts", "worst_gap"], [[k, 1, 1, 0, 1e30]
        for k in range(3)])
    assert plot.main([str(tmp_path), "--no-film"]) == 0
    said = capsys.readouterr().out
    assert "trajectories: left out, no sphere moves" in said and "particles only" in said
    assert [panel[0] for panel in time_series.series(SphereRun(tmp_path))] == ["kinetic energy (J)"]


def test_a_held_sphere_has_no_path_that_counts(space, tmp_path, monkeypatch):
    (tmp_path / "mesh.mesh").write_bytes((space / "mesh.mesh").read_bytes())
    write_csv(tmp_path / "particles.csv", NAMES, [[k, k, i, 0.5, 0.5, 1 + 0.1 * k * i, 0, 0, 0.1 * i, 0, 0, 0, 0.2]
        for k in range(3) for i in range(2)])
    write_csv(tmp_path / "entries.csv", ["t", "id", "radius", "density", "free"], [[0, 0, 0.2, 1, 0], [0, 1, 0.2, 1, 1]])
    kept = []
    monkeypatch.setattr(plot.spheres, "save", lambda figure, path: kept.append(figure))
    plot.spheres.plot_trajectories(SphereRun(tmp_path), None)
    assert kept[0].texts[0].get_text().endswith("path of one sphere (hatched: held)")
    assert [bool(one.get_hatch()) for one in kept[0].axes[0].patches] in ([True, False], [False, True])
    plt.close(kept[0])


def test_tools_that_are_for_plane_runs_say_so(space, folder):
    for words in (["--show", "vorticity"], ["--streamlines"]):
        with pytest.raises(BadInput, match=f"{' '.join(words[:1])}.* is for plane runs; .* is a run in three dimensions"):
            plot.main([str(space), *words])
    for words in (["plot", space, "--show", "vorticity"], ["plot", folder, "--plane", "y=0"], ["plot", space, "--plane", "z=9"],
            ["plot_steady", space], ["plot_contacts", space], ["plot_transport", space], ["transport_table", "--runs", space]):
        done = run_tool(*words)
        assert done.returncode == 3 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1, words
    assert run_tool("check", space, space).returncode == 0


def test_spheres_for_paraview(space, tmp_path):
    points, triangles = unit_sphere()
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    assert len(points) == 162 and len(triangles) == 320 and volume.min() > 0 and volume.sum() == pytest.approx(4.1888, rel=0.04)
    assert run_tool("bodies", space, "--out", tmp_path).returncode == 0
    mesh = meshio.read(tmp_path / "bodies_000001.vtu")
    balls = mesh.points.reshape(2, 162, 3)
    assert np.allclose(balls.mean(axis=1), [[0, 0, 1.25], [0.7, 0.3, 1]], atol=1e-12)
    assert np.allclose(np.linalg.norm(balls - balls.mean(axis=1, keepdims=True), axis=2), [[0.2], [0.25]])
    data = {name: values[0].reshape(2, 320, -1) for name, values in mesh.cell_data.items()}
    assert np.allclose(data["velocity"][1], [3, 4, 12]) and np.allclose(data["omega"][1], [1, 2, 2])
    assert np.allclose(data["contact_force"][0], [-1.2, 0, 1.6]) and np.allclose(data["contact_force"][1], [1.2, 1, -1.6])
    lines = meshio.read(tmp_path / "contacts_000001.vtu")
    assert np.allclose(lines.points.reshape(-1, 2, 3), [[[0, 0, 1.25], [0.7, 0.3, 1]], [[0.7, 0.3, 1], [0.7, 0.04, 1]]])
    assert np.allclose(lines.cell_data["force"][0], [2, 1]) and lines.cell_data["j"][0].tolist() == [9, -4]
    assert np.isnan(meshio.read(tmp_path / "bodies_000000.vtu").cell_data["contact_force"][0]).sum() == 0


def test_a_study_knows_meshes_of_tetrahedra(tmp_path):
    files = {}
    for size, n in ((0.5, 2), (0.25, 4), (0.2, 4)):
        files[size] = tmp_path / f"{size}.mesh"
        write_medit(files[size], block(n))
    assert not same_mesh(*(read_space_mesh(files[size]) for size in (0.5, 0.25)))
    assert true_sizes({size: files[size] for size in (0.5, 0.25)}) == {0.5: 0.5, 0.25: 0.25}
    with pytest.raises(BadInput, match="make the same mesh"):
        true_sizes({size: files[size] for size in (0.25, 0.2)})


def test_a_run_of_freefem_keeps_its_mesh_and_its_open_sides(tmp_path):
    """mesh.mesh had lost its tetrahedra."""
    run_freefem("cases/settling_sphere.edp", "-tend", "0.01", "-fields", "0.01", "-out", tmp_path / "run")
    seen = SphereRun(tmp_path / "run")
    assert dimension_of(tmp_path / "run/mesh.mesh") == 3 and len(seen.whole.mesh.tetrahedra) > 1000 and seen.open == (11, 15)
    assert np.array_equal(np.sort(seen.whole.mesh.tetrahedra), np.sort(seen.whole.field(1)[0].tetrahedra))
    assert (seen.axis, seen.at) == (1, 0) and seen.mirrors == {0: 0.0, 1: 0.0}
    assert seen.extent == pytest.approx((-0.05, 0, 0.1, 0.16))
    mesh, values = seen.field(1)
    assert areas(mesh).sum() == pytest.approx(0.016) and values["velocity"][:, 2].min() < -0.005
