"""Outlines of bodies of any shape, in pictures and for ParaView."""
import meshio
import numpy as np
import pytest

from tests.synthetic import write_csv
from tools import bodies as bodies_command
from tools.base.outlines import loops_of, placed
from tools.base.run_folder import RunFolder
from tools.plot import bodies, contacts as plot_contacts, overlays
from tools.plot.style import plt

SQUARE = [[-1, -1], [1, -1], [1, 1], [-1, 1]]


def area(loop):
    x, y = loop.T
    return 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()


@pytest.mark.parametrize("points, closed, exact", [([[0, 0]], 0, np.pi * 0.25), ([[-1, 2], [2, 6]], 0, 5 + np.pi * 0.25),
    (SQUARE, 1, 4 + 4 + np.pi * 0.25), ([[0, 0], [2, 0], [0, 1]], 1, 1 + 0.5 * (3 + np.sqrt(5)) + np.pi * 0.25)])
def test_a_convex_part_is_one_loop_of_its_area(points, closed, exact):
    """To the polygon that stands for its arcs, 0.13 % of a disk of the radius 0.5."""
    loops = loops_of(np.array(points, float), closed, 0.5)
    assert len(loops) == 1
    assert 0 <= exact - area(loops[0]) < 0.0014 * np.pi * 0.25


def test_a_part_with_an_inner_corner_is_a_union():
    hook = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], float)
    assert len(loops_of(hook, 1, 0.1)) == 7 and len(loops_of(hook, 0, 0.1)) == 5


def test_the_rim_of_a_union_leaves_out_what_lies_within():
    """Two disks of the radius 1 a distance of 1 apart: each shows 2/3 of its rim."""
    disk = loops_of(np.array([[0.0, 0.0]]), 0, 1.0)[0]
    corners = overlays.rim([disk, disk + [1, 0]]).get_path().vertices.reshape(-1, 2, 2)
    assert np.hypot(*(corners[:, 1] - corners[:, 0]).T).sum() == pytest.approx(2 * 4 / 3 * np.pi, rel=0.005)
    middle = corners.mean(axis=1)
    assert (np.hypot(middle[:, 0], middle[:, 1]) > 0.99).all() and (np.hypot(middle[:, 0] - 1, middle[:, 1]) > 0.99).all()


def test_bodies_are_turned_about_their_centres():
    found = placed([np.array([[1.0, 0.0]])], 3, 4, 0.5 * np.pi)
    np.testing.assert_allclose(found[0], [[3, 5]], atol=1e-12)


@pytest.fixture
def made_up(tmp_path):
    """A run of a square that turns by a quarter and of a clump of two disks, with a contact."""
    write_csv(tmp_path / "particles.csv", "step,t,id,x,y,theta,u,v,omega,radius".split(","),
        [[k, k, i, 5 * i, 2, 0.5 * np.pi * k / 2, 0.1, 0, 0, 2] for k in range(3) for i in (1, 2)])
    write_csv(tmp_path / "outlines.csv", "id,part,closed,x,y,radius".split(","), [[1, 0, 1, x, y, 0.5] for x, y in SQUARE]
        + [[2, 1, 0, -0.5, 0, 0.6], [2, 2, 0, 0.5, 0, 0.6]])
    write_csv(tmp_path / "contacts.csv", "t,i,j,gap,nx,ny,impulse,x,y".split(","), [[2, 1, 2, 0, -1, 0, 3, 7, 2],
        [2, 1, -1, 0, 0, 1, 4, 5, 0]])
    write_csv(tmp_path / "motion.csv", ["step", "t", "kinetic_energy", "potential_energy", "worst_gap"], [[k, k, 1, 1, 0]
        for k in range(3)])
    (tmp_path / "run.json").write_text('{"case": "made_up", "parameters": {"-dt": 1}}')
    return tmp_path


def test_pictures_show_the_outlines(made_up, monkeypatch):
    figure, axes = plt.subplots()
    run = plot_contacts.ContactRun(made_up)
    filled = plot_contacts.draw(axes, run, run.frame(1))
    assert list(filled.owner) == [0, 1, 1]
    reach = [path.vertices for path in filled.get_paths()]
    np.testing.assert_allclose([reach[0][:, 0].min(), reach[0][:, 0].max()], 5 + (np.sqrt(2) + 0.5) * np.array([-1, 1]), atol=2e-3)
    drawn = []
    monkeypatch.setattr(plot_contacts, "save", lambda figure, path: drawn.append(figure))
    plot_contacts.plot_chains(run, None)
    lines = max(drawn[0].axes[0].collections, key=lambda part: part.get_zorder())
    ends = {tuple(np.round(end, 9)) for line in lines.get_segments() for end in line}
    assert ends == {(5, 2), (7, 2), (10, 2), (5, 0)}
    plt.close(drawn[0])
    plt.close(figure)
    assert len(list(plot_contacts.shots(run, [0, 2]))) == 2


def test_paraview_gets_the_outlines(made_up):
    assert bodies_command.main([str(made_up)]) == 0
    mesh = meshio.read(made_up / "bodies_000002.vtu")
    ids = np.concatenate(mesh.cell_data["id"])
    assert sorted(ids) == [1, 2, 2]
    sizes = {int(one): sum(abs(area(mesh.points[cell][:, :2])) for block, of in zip(mesh.cells, mesh.cell_data["id"])
        for cell, body in zip(block.data, of) if body == one) for one in (1, 2)}
    assert sizes[1] == pytest.approx(8 + np.pi * 0.25, rel=1e-3) and sizes[2] == pytest.approx(2 * np.pi * 0.36, rel=2e-3)
    run = RunFolder(made_up)
    assert len(bodies.polygons(run, 9.0, run.particles_at(9.0), None).points) == 0  # none has entered, or all have left
    lines, _, forces = bodies.contact_lines(RunFolder(made_up), 2.0, RunFolder(made_up).particles_at(2.0))
    np.testing.assert_allclose(lines, [[[5, 2], [10, 2]], [[5, 2], [5, 0]]])
    np.testing.assert_allclose(forces[1], [-3, 4])
