"""Particles and contacts for ParaView: tools.bodies, read back."""
import xml.etree.ElementTree as xml

import meshio
import numpy as np
import pytest

from tests.conftest import run_freefem, run_tool
from tests.synthetic import write_csv, write_run
from tools.base.run_folder import RunFolder
from tools.plot.bodies import CORNERS, reach
from tools.plot.sphere_bodies import contact_lines

HEAD = "step,t,id,x,y,theta,u,v,omega,radius".split(",")
OF_POLYGON = CORNERS / (2 * np.pi) * np.sin(2 * np.pi / CORNERS)  # its area over that of the ellipse round it


def series(folder, name):
    """[(time, meshio.Mesh or None where the file has no cell)] of NAME.pvd."""
    found = []
    for one in xml.parse(folder / f"{name}.pvd").getroot().iter("DataSet"):
        text = (folder / one.get("file")).read_text()
        found.append((float(one.get("timestep")), None if 'NumberOfCells="0"' in text else meshio.read(folder / one.get("file"))))
    return found


def corners(mesh):
    """The corners (n, CORNERS, 2) of the polygons."""
    return mesh.points[mesh.cells[0].data][:, :, :2]


def areas(mesh):
    x, y = np.moveaxis(corners(mesh), 2, 0)
    return 0.5 * np.sum(x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y, axis=1)


def test_polygons_are_the_particles_of_the_table(tmp_path):
    folder = write_run(tmp_path / "run", steps=20)
    (folder / ".files").touch()
    write_csv(folder / "shapes.csv", ["id", "major", "minor"], [[3, 1, 0.5]])
    write_csv(folder / "entries.csv", ["t", "id", "density", "free"], [[0, k, 1000 + k, k % 2] for k in range(11)])
    done = run_tool("bodies", folder)
    assert done.returncode == 0 and "bodies.pvd" in done.stdout, done.stderr
    run = RunFolder(folder)
    made = series(folder, "bodies")
    assert [time for time, _ in made] == list(np.unique(run.particles["t"]))
    for time, mesh in made:
        rows = {name: column[run.particles["t"] == time] for name, column in run.particles.items()}
        data = {name: values[0] for name, values in mesh.cell_data.items()}
        order = [list(rows["id"]).index(one) for one in data["id"]]
        assert len(data["id"]) == len(rows["id"]) and len(set(data["id"])) == len(order)
        for name, column in (("theta", "theta"), ("omega", "omega"), ("radius", "radius")):
            assert np.allclose(data[name], rows[column][order], rtol=1e-12)
        assert np.allclose(data["velocity"], np.column_stack([rows["u"], rows["v"], 0 * rows["v"]])[order], rtol=1e-12)
        assert np.allclose(corners(mesh).mean(axis=1), np.column_stack([rows["x"], rows["y"]])[order], atol=1e-14)
        aspect = np.where(data["id"] == 3, 0.5, 1.0)
        assert np.allclose(areas(mesh), OF_POLYGON * np.pi * data["radius"]**2 * aspect, rtol=1e-10)
        spoke = corners(mesh)[:, 0] - corners(mesh).mean(axis=1)
        assert np.allclose(np.exp(1j * data["theta"]), (spoke[:, 0] + 1j * spoke[:, 1]) / data["radius"], atol=1e-10)
        assert np.array_equal(data["density"], np.where(data["id"] < 11, 1000 + data["id"], np.nan), equal_nan=True)
    assert {"bodies.pvd", "contacts.pvd", "bodies_000020.vtu"} <= set((folder / ".files").read_text().split())


def test_times_are_those_of_the_fields(folder, tmp_path):
    assert run_tool("bodies", folder, "--out", tmp_path).returncode == 0
    assert [time for time, _ in series(tmp_path, "bodies")] == [time for time, _ in RunFolder(folder).fields]
    assert [time for time, _ in series(tmp_path, "contacts")] == [time for time, _ in RunFolder(folder).fields]


def test_contacts_of_disks_at_rest_carry_their_weight(tmp_path):
    """Disks of mass 100 pi r^2 under gravity 0.02 that lie in a heap."""
    folder = tmp_path / "run"
    run_freefem("cases/falling_particles.edp", "-number", 12, "-tend", 60, "-every", 10, "-out", folder)
    assert run_tool("bodies", folder).returncode == 0
    mesh, lines = series(folder, "bodies")[-1][1], series(folder, "contacts")[-1][1]
    data = {name: values[0] for name, values in mesh.cell_data.items()}
    weight = 100 * np.pi * data["radius"]**2 * 0.02
    assert np.allclose(data["contact_force"][:, 1], weight, rtol=1e-5) and np.all(abs(data["contact_force"][:, 0])
        < 1e-5 * weight.max())
    table = RunFolder(folder).contacts
    last = table["t"] == table["t"].max()
    assert np.allclose(np.sort(lines.cell_data["force"][0]), np.sort(table["impulse"][last]) / 0.02, rtol=1e-10)
    # a line ends at centres, or where the disk touches the wall
    ends = lines.points[lines.cells[0].data][:, :, :2]
    radius = dict(zip(data["id"], data["radius"]))
    for i, j, (begin, end) in zip(lines.cell_data["i"][0], lines.cell_data["j"][0], ends):
        assert np.hypot(*(end - begin)) == pytest.approx(radius[i] + radius.get(j, 0.0), rel=1e-6)
    floor = lines.cell_data["j"][0] == -1
    assert floor.any() and np.all(abs(ends[floor, 1, 1]) < 1e-9)
    assert "contacts_000006.vtu" in (folder / ".files").read_text().split()


def test_where_no_row_stands_no_contact_is_made_up(tmp_path):
    (tmp_path / "run.json").write_text('{"case": "made_up", "parameters": {"-dt": 0.5}}')
    write_csv(tmp_path / "particles.csv", HEAD, [[k, k, one, one, 0, 0, 0, 0, 0, 0.5] for k in (0, 1) for one in (0, 1)])
    write_csv(tmp_path / "contacts.csv", "t,i,j,gap,nx,ny,impulse".split(","), [[1, 1, 0, 0, 1, 0, 3]])
    run = RunFolder(tmp_path)
    run.__dict__["fields"] = []
    run.__dict__["frames"] = [(0.0, None), (0.5, None), (1.0, None)]
    from tools.plot.bodies import write_bodies
    write_bodies(run, tmp_path)
    force = [mesh.cell_data["contact_force"][0] for _, mesh in series(tmp_path, "bodies")]
    assert np.all(force[0] == 0) and np.isnan(force[1][:, 0]).all() and force[2].tolist() == [[-6, 0, 0], [6, 0, 0]]
    assert [mesh is None for _, mesh in series(tmp_path, "contacts")] == [True, True, False]


def test_a_contact_over_a_seam_takes_the_short_way(tmp_path):
    (tmp_path / "run.json").write_text('{"case": "made_up", "period": [4, 0], "low": [0, 0], "parameters": {"-dt": 1}}')
    write_csv(tmp_path / "particles.csv", HEAD, [[1, 1, 0, 0.4, 0, 0, 0, 0, 0, 0.5], [1, 1, 1, 3.5, 0, 0, 0, 0, 0, 0.4],
        [1, 1, 2, 2, 0, 0, 0, 0, 0, 0.4]])
    write_csv(tmp_path / "contacts.csv", "t,i,j,gap,nx,ny,impulse".split(","), [[1, 0, 1, 0, 1, 0, 2]])
    assert run_tool("bodies", tmp_path).returncode == 0
    line = series(tmp_path, "contacts")[0][1].points[:, 0]
    assert sorted(np.mod(line, 4)) == pytest.approx([0.4, 3.5]) and abs(np.ptp(line)) == pytest.approx(0.9)
    ids = series(tmp_path, "bodies")[0][1].cell_data["id"][0]
    assert sorted(ids) == [0, 0, 1, 2]  # that at 0.4 crosses the seam, that at 3.5 does not


def test_spheres_stand_on_both_sides_of_a_seam(tmp_path):
    """One that passes the seam between two rows is not in the middle of the cell meanwhile; its contact takes the short way."""
    (tmp_path / "run.json").write_text('{"case": "made_up", "period": [4, 0, 0], "low": [0, 0, 0], "parameters": {"-dt": 1}}')
    write_csv(tmp_path / "particles.csv", "t,id,x,y,z,u,v,w,omega_x,omega_y,omega_z,radius".split(","),
        [[t, one, x, 0, 0, *6 * [0], 0.5] for t in (0, 1) for one, x in ((0, 3.8 if t == 0 else 0.2), (1, 3.1))])
    write_csv(tmp_path / "contacts.csv", "t,i,j,gap,nx,ny,nz,impulse".split(","), [[1, 0, 1, 0.1, 1, 0, 0, 2]])
    run = RunFolder(tmp_path)
    assert run.in_space and [list(run.tracks[one]["x"]) for one in (0, 1)] == [[3.8, pytest.approx(4.2)], [3.1, 3.1]]
    ids, x, *_ = run.particles_at(0.5)
    assert sorted(zip(ids, np.round(x, 9))) == [(0, 0), (0, 4), (1, 3.1)]
    lines, _, forces = contact_lines(run, 1.0)
    assert np.ptp(lines[0, :, 0]) == pytest.approx(1.1) and forces[0].tolist() == [2, 0, 0]


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0, 4.0])
def test_the_point_of_an_ellipse_with_a_given_normal(angle):
    n, theta = np.array([np.cos(angle), np.sin(angle)]), 0.3
    turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    s = np.linspace(0, 2 * np.pi, 20001)
    rim = turn @ np.array([2 * np.cos(s), 0.5 * np.sin(s)])
    assert np.allclose(reach(n, theta, 2.0, 0.5), rim[:, np.argmax(n @ rim)], atol=1e-3)


def test_a_later_call_leaves_no_file_of_an_earlier_one(tmp_path):
    folder = write_run(tmp_path / "run", steps=20)
    (folder / "bodies_of_mine.vtu").write_text("mine")
    assert run_tool("bodies", folder).returncode == 0
    done = run_tool("bodies", folder, "--most", 5)
    assert done.returncode == 0 and "21 times are more than 5" in done.stdout
    assert len(list(folder.glob("bodies_0*.vtu"))) == len(series(folder, "bodies")) == 5
    assert (folder / "bodies_of_mine.vtu").exists()


@pytest.mark.parametrize("table, words", [(None, "no particles.csv"), ([HEAD], "has no rows"), (["t", "id"], "has no column"),
    ("nan", "not a finite number")])
def test_runs_that_cannot_be_shown_are_refused_in_a_line(table, words, tmp_path):
    (tmp_path / "run.json").write_text('{"case": "made_up"}')
    if table == "nan":
        write_csv(tmp_path / "particles.csv", HEAD, [[0, 0, 0, float("nan"), 0, 0, 0, 0, 0, 1]])
    elif table:
        write_csv(tmp_path / "particles.csv", table[0] if isinstance(table[0], list) else table, [])
    done = run_tool("bodies", tmp_path)
    assert done.returncode == 3 and words in done.stderr and done.stderr.count("\n") == 1 and not list(tmp_path.glob("*.pvd"))
