"""tools.plot_contacts: frames, energies, films of contacts alone."""
import pytest

from tests.conftest import run_tool
from tests.synthetic import write_csv, write_run
from tools.base.command import BadInput
from tools.base.run_folder import RunFolder
from tools.plot import resolved as plot, contacts as plot_contacts, series as timeline, transport as plot_transport
from tools.plot.style import plt


@pytest.mark.parametrize("low", [0.0, -0.8, -8000.25])
def test_the_axis_of_frames_of_contacts_stands_on_the_page(tmp_path, monkeypatch, low):
    """However wide the numbers beside it are."""
    write_csv(tmp_path / "particles.csv", "step,t,id,x,y,theta,u,v,omega,radius".split(","),
              [[k, k, i, 0.1 * i, low + 0.9 * i / 9 - 0.01 * k, 0, 0, -0.01 * k, 0, 0.02] for k in range(4) for i in range(10)])
    (tmp_path / "run.json").write_text('{"case": "made_up"}')
    drawn = []
    monkeypatch.setattr(plot_contacts, "save", lambda figure, path: drawn.append(figure))
    plot_contacts.plot_frames(plot_contacts.ContactRun(tmp_path), None)
    drawn[0].canvas.draw()
    assert min(axes.get_tightbbox().x0 for axes in drawn[0].axes) > 0
    plt.close(drawn[0])


@pytest.mark.parametrize("width", [1, 4, 7, 10, 30])
def test_the_labels_of_heights_of_low_scenes_keep_apart(tmp_path, monkeypatch, width):
    write_csv(tmp_path / "particles.csv", "step,t,id,x,y,theta,u,v,omega,radius".split(","),
              [[k, k, i, width * i / 9, i / 9, 0, 0, -0.01 * k, 0, 0.02] for k in range(4) for i in range(10)])
    drawn = []
    monkeypatch.setattr(plot_contacts, "save", lambda figure, path: drawn.append(figure))
    plot_contacts.plot_frames(plot_contacts.ContactRun(tmp_path), None)
    drawn[0].draw_without_rendering()
    one = drawn[0].axes[0]
    low, high = one.get_ylim()
    boxes = [label.get_window_extent() for label, tick in zip(one.get_yticklabels(), one.get_yticks()) if low <= tick <= high]
    assert boxes and all(a.y1 < b.y0 for a, b in zip(boxes, boxes[1:]))
    plt.close(drawn[0])


def test_the_energies_have_their_names_above_them(tmp_path, monkeypatch):
    write_run(tmp_path, steps=10)
    write_csv(tmp_path / "motion.csv", ["step", "t", "kinetic_energy", "potential_energy", "worst_gap"], [[k, k, 1 + k, 10 - k, 0]
        for k in range(10)])
    drawn = []
    monkeypatch.setattr(plot_contacts, "save", lambda figure, path: drawn.append(figure))
    plot_contacts.plot_energy(plot_contacts.ContactRun(tmp_path), None)
    drawn[0].canvas.draw()
    top = drawn[0].axes[0]
    assert top.get_legend().get_window_extent().y0 >= top.get_window_extent().y1 - 1
    plt.close(drawn[0])


def test_an_energy_of_nothing_is_not_drawn_as_one(tmp_path, monkeypatch):
    """Particles at rest had a millionth of the largest energy in the picture."""
    write_run(tmp_path, steps=10)
    write_csv(tmp_path / "motion.csv", ["step", "t", "kinetic_energy", "potential_energy", "worst_gap"],
        [[k, k, 8 - k if k < 8 else 0, 1, 0] for k in range(10)])
    drawn = []
    monkeypatch.setattr(plot_contacts, "save", lambda figure, path: drawn.append(figure))
    plot_contacts.plot_energy(plot_contacts.ContactRun(tmp_path), None)
    top = drawn[0].axes[0]
    low, _ = top.get_ylim()
    kinetic, potential = (line.get_ydata() for line in top.lines)
    assert (kinetic[:8] > low).all() and (kinetic[8:] < low).all() and (potential < low).all()
    plt.close(drawn[0])


@pytest.mark.parametrize("t_end", [0.15, 0.35, 0.2, 4e4])
def test_the_labels_of_time_keep_apart(tmp_path, monkeypatch, t_end):
    folder, drawn = write_run(tmp_path / "run", steps=20, t_end=t_end), []
    monkeypatch.setattr(timeline, "save", lambda figure, path: drawn.append(figure))
    timeline.plot_series(RunFolder(folder), None)
    figure = drawn[0]
    figure.canvas.draw()
    for one in figure.axes:
        boxes = sorted(((box.x0, box.x1) for box in (label.get_window_extent() for label in one.get_xticklabels()
            if label.get_text())))
        assert all(right[0] - left[1] > 12 for left, right in zip(boxes, boxes[1:]))  # two digits
    plt.close(figure)


def test_a_run_of_contacts_alone_is_left_to_its_own_pictures(freefem, tmp_path):
    assert freefem("cases/falling_particles.edp", "-tend", "0.1", "-out", tmp_path / "run").returncode == 0
    with pytest.raises(BadInput, match="plot_contacts"):
        plot.main([str(tmp_path / "run")])
    done = run_tool("plot_contacts", tmp_path / "run", "--only", "energy")
    assert done.returncode == 0 and done.stderr == "", "a finished run is no reason to warn"


def test_contacts_of_one_time_are_drawn_without_a_film(freefem, tmp_path, capsys):
    """Rows behind a restart, say; a film that is asked for is refused."""
    words = ["cases/falling_particles.edp", "-number", 3, "-dt", 0.01, "-every", 5, "-checkpoint", 5]
    freefem(*words, "-tend", 0.1, "-out", tmp_path / "run")
    freefem(*words, "-tend", 0.12, "-restart", tmp_path / "run", "-out", tmp_path / "on")
    assert plot_contacts.main([str(tmp_path / "on")]) == 0
    assert "film: left out, only one time to show" in capsys.readouterr().out and (tmp_path / "on" / "energy.png").is_file()
    with pytest.raises(BadInput, match="only one time"):
        plot_contacts.main([str(tmp_path / "on"), "--only", "film"])


def test_more_times_than_fit_on_a_page_are_refused(tmp_path):
    folder = write_run(tmp_path / "run", steps=20)
    write_csv(folder / "steps.csv", ["step", "t"], [[k, 0.05 * k] for k in range(21)])
    with pytest.raises(BadInput, match="200 times are more than fit on a page"):
        plot_transport.main([str(folder), "--times", ",".join(f"{0.005 * k:g}" for k in range(200))])


def test_forces_of_contacts_without_a_step_are_refused(tmp_path):
    """They were drawn as infinite."""
    folder = write_run(tmp_path, steps=10)
    write_csv(folder / "motion.csv", ["step", "t", "kinetic_energy", "potential_energy", "worst_gap"], [[0, 0, 1, 1, 0]])
    with pytest.raises(BadInput, match="no row behind the start"):
        plot_contacts.plot_chains(plot_contacts.ContactRun(folder), folder / "chains.png")


def test_a_run_of_contacts_without_a_row_of_its_motion_is_refused(tmp_path):
    """It has begun and was cut off: rows of particles and contacts may be there before the first of motion.csv."""
    write_csv(tmp_path / "particles.csv", "t id x y theta u v radius".split(), [[0.1, 0, 0, 1, 0, 0, -1, 0.5]])
    write_csv(tmp_path / "contacts.csv", "t i j gap nx ny impulse".split(), [[0.1, 0, -1, 0, 0, 1, 2]])
    write_csv(tmp_path / "motion.csv", "step t kinetic_energy potential_energy worst_gap".split(), [])
    with pytest.raises(BadInput, match="motion.csv has no rows"):
        plot_contacts.main([str(tmp_path)])


BODIES = """include "lib/case.idp"
optCase("bodies", "an ellipse beside a held disk");
real gravityX = 0, gravityY = -10;
macro caseWalls() contactWallSegment(0, 0, 9, 0); // EOM
macro caseParticles() bodyEllipse(2, 4, 2, 1, 0.3, 1); bodyHeld(bodyDisk(6, 4, 1.5, 1)); // EOM
include "scripts/contacts.edp"
"""


def test_ellipses_and_held_bodies_of_contacts_are_drawn_as_such(freefem_text, tmp_path, monkeypatch):
    """An ellipse was a disk in pictures and for ParaView, and a held body looked free."""
    freefem_text(BODIES, "-tend", 0.02, "-out", tmp_path / "run")
    run = plot_contacts.ContactRun(tmp_path / "run")
    assert run.aspect(0) == 0.5 and run.aspect(1) == 1 and run.held == {1}
    drawn = []
    monkeypatch.setattr(plot_contacts, "save", lambda figure, path: drawn.append(figure))
    plot_contacts.plot_frames(run, None)
    bodies, hatched = [one for one in drawn[0].axes[0].collections if type(one).__name__ == "EllipseCollection"]
    assert sum(abs(bodies._heights - 0.5 * bodies._widths) < 1e-9) == 1 and hatched.get_hatch() and len(hatched.get_offsets()) == 1
    assert drawn[0].get_suptitle().endswith("(hatched: held)")
    plt.close(drawn[0])
    monkeypatch.setattr(plot_contacts, "shot", lambda figure: figure.axes[0].get_title())
    assert next(plot_contacts.shots(run, [0])).endswith("(hatched: held)")


def test_a_film_of_contacts_has_as_many_frames_as_asked_for(tmp_path):
    """By the option that films of flows have too."""
    from PIL import Image
    write_csv(tmp_path / "particles.csv", "step,t,id,x,y,theta,u,v,omega,radius".split(","),
        [[k, k, i, i, 1 - 0.1 * k, 0, 0, -0.1, 0, 0.2] for k in range(6) for i in range(2)])
    write_csv(tmp_path / "motion.csv", "step,t,kinetic_energy,potential_energy,worst_gap".split(","), [[k, k, 1, 1, 0.1]
        for k in range(6)])
    assert plot_contacts.main([str(tmp_path), "--only", "film", "--gif", "--frames", "3"]) == 0
    with Image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == 3
