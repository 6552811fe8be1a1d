"""tools.plot, tools.film and the readers they stand on: what is made, and from what."""
import json
import re
import subprocess
import sys

import numpy as np
import pytest

from tests.conftest import run_tool
from tests.synthetic import ROOT, write_csv, write_run
from tools import film, plot, plot_contacts, plot_transport
from tools.command import BadInput
from tools.film import frame_rate, make_film, mp4_possible
from tools.mesh_files import chains, read_mesh
from tools.plotting import draw_outline, frame, panels, plt, save, speed_top
from tools.run_folder import RunFolder
from tools.tables import read_table


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A made-up run with fields written by FreeFEM."""
    return write_run(tmp_path_factory.mktemp("plot") / "run", fields=8, n=8)


@pytest.fixture
def run(folder):
    return RunFolder(folder)


def test_all_pictures_are_made(folder, tmp_path, capsys):
    assert plot.main([str(folder), "--out", str(tmp_path / "new" / "figures")]) == 0
    said = capsys.readouterr().out
    out = tmp_path / "new" / "figures"
    for name in ("fields.png", "trajectories.png", "series.png"):
        assert (out / name).stat().st_size > 10_000 and str(out / name) in said
        picture = plt.imread(out / name)
        assert picture.shape[1] > 1000 and picture[:, :, :3].std() > 0.02  # not blank
    films = list(out.glob("film.*"))
    assert len(films) == 1 and films[0].stat().st_size > 5_000
    assert not list(out.glob("*part*"))


def test_the_film_has_a_frame_per_field(run, tmp_path):
    if not mp4_possible():
        pytest.skip("no ffmpeg here: the film is a gif")
    import imageio_ffmpeg
    path = make_film(run, tmp_path)
    frames, _ = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert path.name == "film.mp4" and frames == 9


def test_a_gif_where_no_mp4_can_be_made(run, tmp_path):
    from PIL import Image
    path = make_film(run, tmp_path, most=4, gif=True)
    with Image.open(path) as film:
        assert path.name == "film.gif" and film.n_frames == 4


@pytest.mark.parametrize("binary", [True, False])
def test_fields_of_freefem_are_read_in_both_forms(tmp_path, binary):
    run = RunFolder(write_run(tmp_path / "run", fields=2, n=6, binary=binary))
    assert [t for t, _ in run.fields] == [0, 0.5, 1]
    mesh, values = run.field(2)
    assert values["velocity"].shape == (len(mesh.points), 2) and values["pressure"].shape == (len(mesh.points),)
    assert np.allclose(values["pressure"], 100 * (1 - mesh.points[:, 0]), atol=1e-4)
    assert np.allclose(mesh.points, run.mesh.points, atol=1e-6)
    assert np.array_equal(np.sort(mesh.triangles), np.sort(run.mesh.triangles))


def test_the_mesh_keeps_its_labels(run):
    assert set(run.mesh.labels) == {1, 2, 3, 4, 5}
    ends = run.mesh.points[run.mesh.edges]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert lengths[run.mesh.labels == 1].sum() == pytest.approx(0.2)
    corner = run.mesh.points[run.mesh.triangles]
    a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    assert 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() == pytest.approx(0.2 - 0.01 * 0.06 - 0.04 * 0.05)


def test_sides_that_are_no_walls_are_dashed(run):
    figure, axes = plt.subplots()
    draw_outline(axes, run.mesh, (3,))
    dashed = [line for line in axes.collections if line.get_linestyle()[0][1] is not None]
    plt.close(figure)
    assert len(dashed) == 1 and len(dashed[0].get_segments()) == len(list(chains(run.mesh.edges[run.mesh.labels == 3])))


def test_chains_use_every_edge_once():
    ring = np.array([[0, 1], [2, 1], [2, 3], [3, 0], [5, 6], [7, 6]])
    lines = chains(ring)
    used = sorted(tuple(sorted(pair)) for line in lines for pair in zip(line[:-1].tolist(), line[1:].tolist()))
    assert used == sorted(tuple(sorted(pair)) for pair in ring.tolist())
    assert sorted(len(line) for line in lines) == [3, 5]


def test_without_a_list_of_fields_times_come_from_the_steps(tmp_path):
    folder = write_run(tmp_path / "run", fields=2, n=6)
    (folder / "fields.pvd").unlink()
    run = RunFolder(folder)
    assert [path.name for _, path in run.fields] == ["fields_0.vtu", "fields_10.vtu", "fields_20.vtu"]
    assert [t for t, _ in run.fields] == pytest.approx([0, 0.1, 0.2])


def test_a_run_without_fields_or_mesh_is_drawn_from_its_particles(tmp_path, capsys):
    folder = write_run(tmp_path / "run", steps=20)
    assert plot.main([str(folder), "--frames", "5"]) == 0
    assert (folder / "fields.png").is_file() and (folder / "trajectories.png").is_file()
    assert "fields.png (particles only: the run wrote no velocity" in capsys.readouterr().out


def test_what_a_run_does_not_hold_is_said(tmp_path, capsys):
    write_csv(tmp_path / "fluid.csv", ["t", "kinetic_energy"], [[0, 1], [1, 2]])
    assert plot.main([str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "series:" in said and "trajectories: left out" in said and "film: left out" in said
    write_csv(tmp_path / "fluid.csv", ["t", "kinetic_energy"], [])
    with pytest.raises(BadInput, match="nothing"):
        plot.main([str(tmp_path)])


def test_particles_are_where_the_rows_say(run):
    t = run.particles["t"][500]
    ids, x, y, theta, radius, minor = run.particles_at(t)
    here = run.particles["t"] == t
    assert np.array_equal(ids, run.particles["id"][here])
    assert np.allclose(x, run.particles["x"][here]) and np.allclose(radius, run.particles["radius"][here])
    between = run.particles_at(t + 0.5 * 0.01)
    assert np.allclose(between[1][:1], x[:1] + 0.005 * (run.tracks[0]["x"][1] - run.tracks[0]["x"][0]) / 0.01)


def test_a_track_across_a_periodic_seam_is_cut():
    track = {"x": np.array([0.7, 0.9, 0.1, 0.3]), "y": np.zeros(4)}
    pieces = plot.broken(track, (0, 0, 1, 1))
    assert [len(piece) for piece in pieces] == [2, 2]


def test_particles_of_a_periodic_run_are_drawn_inside_and_on_both_sides_of_its_seams(tmp_path):
    (tmp_path / "run.json").write_text('{"case": "made_up", "period": [2, 1]}')
    head = "step,t,id,x,y,theta,u,v,omega,radius\n"
    (tmp_path / "particles.csv").write_text(head + "0,0,4,7.05,0.5,0,1,0,0,0.1\n0,0,5,-0.05,-0.02,0,1,0,0,0.1\n1,1,4,6.75,0.5,0,1,0,0,0.1\n1,1,5,-0.05,0.98,0,1,0,0,0.1\n")
    run = RunFolder(tmp_path)
    run.__dict__["extent"] = (1.0, 0.0, 2.0, 1.0)  # as a mesh has it
    rows = run.particles_at(0.0).T
    assert np.allclose(sorted(map(tuple, rows[:, :3])), sorted([(4, 1.05, 0.5), (4, 3.05, 0.5), (5, 1.95, 0.98), (5, 1.95, -0.02)]))
    assert np.allclose(run.particles_at(0.5)[:3, 0], [4, 2.9, 0.5])  # half way
    assert run.clip == run.extent
    pieces = plot.broken(run.tracks[4], run.extent, run.period)  # both reach over the seam at x = 1 and 3
    assert [piece[:, 0].tolist() for piece in pieces] == [pytest.approx([1.05, 0.75]), pytest.approx([3.05, 2.75])]
    assert [len(piece) for piece in plot.broken({"x": np.array([1.2, 2.4, 3.4, 3.6, 2.8]), "y": np.full(5, 0.5)}, run.extent, (2, 0))] == [3, 4, 2]


def test_six_times_are_spread_and_end_at_the_end():
    frames = [(0.1 * k, k) for k in range(61)]
    assert [k for _, k in plot.spread(frames)] == [10, 20, 30, 40, 50, 60]
    assert plot.spread(frames[:4]) == frames[:4]
    uneven = [(t, k) for k, t in enumerate([0, 0.01, 0.02, 0.03, 0.04, 0.05, 10])]
    picked = [k for _, k in plot.spread(uneven)]
    assert picked == sorted(set(picked)) and len(picked) == 6 and picked[-1] == 6


@pytest.mark.parametrize("w,h", [(1, 0.2), (2, 6), (1, 1), (22, 4.1), (0.01, 0.3), (50, 1)])
def test_panels_fit_a_page_and_do_not_overlap(w, h):
    figure, axes, bar = panels(6, (0, 0, w, h))
    width, height = figure.get_size_inches()
    assert width <= 7.3 and height <= 8.7
    boxes = [one.get_position() for one in axes] + [bar.get_position()]
    for k, a in enumerate(boxes):
        assert 0 <= a.x0 < a.x1 <= 1 and 0 <= a.y0 < a.y1 <= 1
        for b in boxes[k + 1:]:
            assert a.x1 <= b.x0 or b.x1 <= a.x0 or a.y1 <= b.y0 or b.y1 <= a.y0
    first = axes[0].get_position()
    assert (first.width * width) / (first.height * height) == pytest.approx(w / h)
    plt.close(figure)


def test_a_few_fast_nodes_do_not_darken_the_picture():
    speeds = np.ones(10_000)
    speeds[0] = 50
    assert speed_top([speeds]) == (1.0, "max")
    assert speed_top([np.linspace(0, 2, 1000)])[1] == "neither"
    assert speed_top([np.zeros(5)]) == (1.0, "neither")


def test_units_are_those_of_the_options(tmp_path):
    folder = write_run(tmp_path / "run", steps=4)
    assert RunFolder(folder).units["length"] == "m"
    (folder / "run.json").write_text(json.dumps({"case": "settling_disk", "units": {"-rhos": "g/cm3", "-penalty": "m2 s/kg"}}))
    assert RunFolder(folder).units == {"length": "cm", "time": "s", "mass": "g"}
    for units, names in (({"-rho": "mg/mm3", "-dt": "s"}, ("mm", "mg")), ({"-rhof": "ng/um3", "-mu": "ng/(um ms)"}, ("um", "ng")), ({"-length": "m", "-penalty": "m s/kg"}, ("m", "kg")), ({"-reynolds": "", "-dt": "s", "-contact-tol": "mean radii"}, ("L", "M")), ({"-reynolds": "", "-outlet": "H", "-inlet": "h"}, ("L", "M"))):
        (folder / "run.json").write_text(json.dumps({"case": "mine", "units": units}))
        assert (RunFolder(folder).units["length"], RunFolder(folder).units["mass"]) == names


def test_film_speed():
    assert frame_rate(10) == 4 and frame_rate(120) == 10 and frame_rate(3000) == 25


def test_a_row_cut_short_is_named(tmp_path):
    (tmp_path / "x.csv").write_text("# made up\nt,u\n0,1\n1\n")
    with pytest.raises(BadInput, match="line 4: 1 values where the header names 2"):
        read_table(tmp_path / "x.csv")


def test_a_table_of_a_run_that_was_cut_off_anywhere_is_refused(tmp_path):
    """Within the last number too, which can be read then; a table of another hand may lack the end of its last line."""
    text, path = "t,x,radius\n0,0,0.0125\n1,0,0.0125\n", tmp_path / "particles.csv"
    for cut in range(1, len(text)):
        path.write_text(text[:cut])
        if text[cut - 1] == "\n":
            assert len(RunFolder(tmp_path).table("particles")["t"]) == text[:cut].count("\n") - 1
        else:
            with pytest.raises(BadInput, match=f"particles.csv, line {text[:cut].count(chr(10)) + 1}: the line has no end"):
                RunFolder(tmp_path).table("particles")
    assert read_table(path)["radius"].tolist() == [0.0125, 0.0125]


def test_a_number_with_a_sharp_in_it_is_none(tmp_path):
    (tmp_path / "x.csv").write_text("t,u\n0,1\n1,0.01#25\n")
    with pytest.raises(BadInput, match="line 3: column u needs a number, not '0.01#25'"):
        read_table(tmp_path / "x.csv")


@pytest.mark.parametrize("break_it,words", [
    (lambda f: (f / "mesh.mesh").write_text("Vertices\n3\n0 0"), "mesh"),
    (lambda f: (f / "mesh.mesh").write_bytes(b"\xff\xfe\x00"), "mesh"),
    (lambda f: (f / "run.json").write_text("{"), "run.json"),
    (lambda f: (f / "fields.pvd").write_text("<VTKFile>"), "fields.pvd"),
    (lambda f: next(f.glob("fields_80.vtu")).write_text("<VTKFile><Unstr"), "fields_80.vtu"),
    (lambda f: (f / "particles.csv").write_text("t,id\n0,1\n"), "no column"),
])
def test_a_damaged_run_ends_with_one_line(folder, tmp_path, break_it, words):
    import shutil
    copy = tmp_path / "run"
    shutil.copytree(folder, copy)
    break_it(copy)
    done = run_tool("plot", copy, "--no-film")
    assert done.returncode == 3, done.stdout + done.stderr
    assert done.stderr.count("\n") == 1 and words in done.stderr


def damaged(path, old, new):
    """The first of these words in a file replaced; old "": the whole file."""
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1) if old else new)


@pytest.mark.parametrize("name, old, new, words", [
    ("particles.csv", "\n0,0,0,", "\n0,nan,0,", "particles.csv, line 2: t is nan"),
    ("fluid.csv", "\n1,0.05,", "\n1,inf,", "fluid.csv, line 3: t is inf"),
    ("shapes.csv", "", "id,major\n0,1\n", "shapes.csv has no column minor"),
    ("run.json", '"status"', '"period": "wide", "status"', '"period" must be two numbers'),
    ("run.json", '"status"', '"period": [1, "a"], "status"', '"period" must be two numbers'),
    ("run.json", '"status"', '"low": [1], "status"', '"low" must be two numbers'),
    ("run.json", '"status"', '"units": [1], "status"', '"units" must be an object'),
    ("run.json", '"versions"', '"parameters": 3, "versions"', '"parameters" must be an object'),
])
def test_damaged_tables_are_named(tmp_path, name, old, new, words):
    folder = write_run(tmp_path / "run", steps=20)
    write_csv(folder / "shapes.csv", ["id", "major", "minor"], [[0, 0.01, 0.005]])
    damaged(folder / name, old, new)
    with pytest.raises(BadInput, match=re.escape(words)):
        plot.main([str(folder), "--no-film"])


@pytest.mark.parametrize("name, old, new, words", [
    ("particles.csv", "\n0,0,0,", "\n0,0,0,nan,", "columns"),
    ("particles.csv", ",0.9,0,10,", ",nan,0,10,", "particles.csv, line 2: u is nan"),
    ("particles.csv", "theta,u,v", "theta,a,b", "particles.csv has no column u"),
    ("motion.csv", "\n0,0,1,", "\n0,0,nan,", "motion.csv, line 2: kinetic_energy is nan"),
    ("contacts.csv", "0.0001", "nan", "contacts.csv, line 2: impulse is nan"),
    ("contacts.csv", "\n1,0,1", "\n1,0,99", "contacts.csv names particle 99 at t = 1"),
    ("walls.csv", "0,0,1,0", "0,0,1,nan", "walls.csv, line 2: y2 is nan"),
])
def test_damaged_runs_of_contacts_are_named(tmp_path, name, old, new, words):
    folder = write_run(tmp_path / "run", steps=20)
    write_csv(folder / "motion.csv", ["step", "t", "kinetic_energy", "potential_energy", "worst_gap"], [[k, 0.05 * k, 1, 0, 0] for k in range(21)])
    write_csv(folder / "walls.csv", ["x1", "y1", "x2", "y2"], [[0, 0, 1, 0]])
    write_csv(folder / "contacts.csv", "t,i,j,gap,nx,ny,impulse".split(","), [[1, 0, 1, 0, 1, 0, 1e-4]])
    assert plot_contacts.main([str(folder), "--only", "energy"]) == 0
    damaged(folder / name, old, new)
    with pytest.raises(BadInput, match=words):
        plot_contacts.main([str(folder), "--only", "chains", "energy"])


@pytest.mark.parametrize("words", [["nothing"], [], ["tools"], ["tools", "--frames", "1"], ["tools", "--only", "all"]])
def test_bad_input_is_one_line_and_status_3(words):
    done = run_tool("plot", *words)
    assert done.returncode == 3 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1


@pytest.mark.parametrize("tool", ["plot", "check", "study", "validate"])
def test_every_tool_has_help(tool):
    done = subprocess.run([sys.executable, "-m", f"tools.{tool}", "--help"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0 and f"python -m tools.{tool}" in done.stdout


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
    write_csv(tmp_path / "motion.csv", ["step", "t", "kinetic_energy", "potential_energy", "worst_gap"], [[k, k, 1 + k, 10 - k, 0] for k in range(10)])
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
    write_csv(tmp_path / "motion.csv", ["step", "t", "kinetic_energy", "potential_energy", "worst_gap"], [[k, k, 8 - k if k < 8 else 0, 1, 0] for k in range(10)])
    drawn = []
    monkeypatch.setattr(plot_contacts, "save", lambda figure, path: drawn.append(figure))
    plot_contacts.plot_energy(plot_contacts.ContactRun(tmp_path), None)
    top = drawn[0].axes[0]
    low, _ = top.get_ylim()
    kinetic, potential = (line.get_ydata() for line in top.lines)
    assert (kinetic[:8] > low).all() and (kinetic[8:] < low).all() and (potential < low).all()
    plt.close(drawn[0])


def test_the_names_of_the_series_are_no_longer_than_their_axes(tmp_path, monkeypatch):
    folder, drawn = write_run(tmp_path / "run", steps=20), []
    table = read_table(folder / "fluid.csv")
    write_csv(folder / "fluid.csv", [*table, "top_speed"], np.column_stack([*table.values(), np.ones(21)]))
    monkeypatch.setattr(plot, "save", lambda figure, path: drawn.append(figure))
    plot.plot_series(RunFolder(folder), None)
    drawn[0].canvas.draw()
    assert len(drawn[0].axes) == 6
    for one in drawn[0].axes:
        assert one.yaxis.label.get_window_extent().height <= one.get_window_extent().height
    plt.close(drawn[0])


def test_a_series_of_one_row_is_a_mark(tmp_path, monkeypatch):
    write_csv(tmp_path / "fluid.csv", ["t", "flux_in", "flux_out", "kinetic_energy"], [[0.5, -1, 1, 2]])
    drawn = []
    monkeypatch.setattr(plot, "save", lambda figure, path: drawn.append(figure))
    plot.plot_series(RunFolder(tmp_path), None)
    lines = [line for one in drawn[0].axes for line in one.lines]
    assert len(lines) == 3 and all(line.get_marker() == "." for line in lines)
    plt.close(drawn[0])


def test_a_flow_without_particles_has_no_panels_of_them(tmp_path):
    folder = write_run(tmp_path / "run", steps=20)
    table = read_table(folder / "fluid.csv")
    assert {"number", "worst overlap / radius"} < {panel[0] for panel in plot.series(RunFolder(folder))}
    for name in ("particles", "contacts"):
        table[name][:] = 0
    write_csv(folder / "fluid.csv", table, np.column_stack([*table.values()]))
    assert [panel[0] for panel in plot.series(RunFolder(folder))] == ["flux (m$^2$/s)", "pressure drop (Pa)", "kinetic energy (J/m)"]


def test_what_rounding_lets_through_a_turning_cylinder_is_no_flux(run, monkeypatch):
    table = {name: values.copy() for name, values in run.fluid.items()}
    table["top_speed"] = 1 + 0 * table["t"]
    for factor in (1, 2e-17):
        table["flux_in"], table["flux_out"] = factor * table["flux_in"], factor * table["flux_out"]
        monkeypatch.setitem(run.__dict__, "fluid", table)
        assert ("flux (m$^2$/s)" in [panel[0] for panel in plot.series(run)]) == (factor == 1)


def test_the_title_of_paths_of_ellipses_gives_their_long_axis(tmp_path, monkeypatch):
    folder, drawn = write_run(tmp_path / "run", number=2, steps=20), []
    table = read_table(folder / "particles.csv")
    table["radius"][:] = 0.01
    write_csv(folder / "particles.csv", table, np.column_stack([*table.values()]))
    monkeypatch.setattr(plot, "save", lambda figure, path: drawn.append(figure))
    for words in ("diameter", "long axis"):
        plot.plot_trajectories(RunFolder(folder), None)
        assert drawn[-1].texts[0].get_text().endswith(f"paths of 2 particles, {words} 0.02 m")
        plt.close(drawn[-1])
        write_csv(folder / "shapes.csv", ["id", "major", "minor"], [[0, 0.01, 0.005]])


@pytest.mark.parametrize("times", ["inf", "nan", "-0.1", "0.2,1.1"])
def test_times_of_a_transport_run_lie_within_it(tmp_path, times):
    write_run(tmp_path, steps=10)
    write_csv(tmp_path / "steps.csv", ["step", "t"], [[k, 0.1 * k] for k in range(11)])
    assert plot_transport.main([str(tmp_path), "--times=0,1", "--out", str(tmp_path / "out")]) == 0
    with pytest.raises(BadInput, match="is not between 0 and 1 s"):
        plot_transport.main([str(tmp_path), f"--times={times}"])


def test_the_reference_of_mesh_files_is_read(tmp_path):
    (tmp_path / "t.mesh").write_text("MeshVersionFormatted 2\nDimension 2\nVertices\n3\n0 0 1\n1 0 1\n0 1 1\n"
                                     "Edges\n1\n1 2 7\nTriangles\n1\n1 2 3 0\nEnd\n")
    mesh = read_mesh(tmp_path / "t.mesh")
    assert mesh.labels.tolist() == [7] and mesh.triangles.tolist() == [[0, 1, 2]] and mesh.edges.tolist() == [[0, 1]]


@pytest.mark.parametrize("t_end", [0.15, 0.35, 0.2, 4e4])
def test_the_labels_of_time_keep_apart(tmp_path, monkeypatch, t_end):
    folder, drawn = write_run(tmp_path / "run", steps=20, t_end=t_end), []
    monkeypatch.setattr(plot, "save", lambda figure, path: drawn.append(figure))
    plot.plot_series(RunFolder(folder), None)
    figure = drawn[0]
    figure.canvas.draw()
    for one in figure.axes:
        boxes = sorted(((box.x0, box.x1) for box in (label.get_window_extent() for label in one.get_xticklabels() if label.get_text())))
        assert all(right[0] - left[1] > 12 for left, right in zip(boxes, boxes[1:]))  # two digits
    plt.close(figure)


def test_a_path_over_a_seam_is_drawn_to_it_on_both_sides_and_no_further(tmp_path, monkeypatch):
    folder, drawn = write_run(tmp_path / "run", number=1, steps=4), []
    (folder / "run.json").write_text('{"case": "made_up", "period": [0.4, 0]}')
    monkeypatch.setattr(plot, "save", lambda figure, path: drawn.append(figure))
    run = RunFolder(folder)
    run.__dict__["extent"] = (0.0, -0.1, 0.4, 0.2)
    plot.plot_trajectories(run, None)
    lines = [line for line in drawn[0].axes[0].lines if len(line.get_xdata())]
    ends = [(line.get_xdata()[0], line.get_xdata()[-1]) for line in lines]
    assert len(ends) > 1 and all(a[1] >= 0.4 and b[0] <= 0 for a, b in zip(ends, ends[1:]))
    drawn[0].canvas.draw()
    seams = drawn[0].axes[0].transData.transform([(0, 0), (0.4, 0)])[:, 0]
    assert all((line.get_clip_box().x0, line.get_clip_box().x1) == pytest.approx(seams) for line in lines)
    plt.close(drawn[0])


def test_a_run_that_failed_is_drawn_as_one(run, tmp_path, capsys):
    import shutil
    copy = tmp_path / "run"
    shutil.copytree(run.folder, copy)
    text = (copy / "run.json").read_text()
    (copy / "run.json").write_text(text.replace('"finished"', '"failed (4)"'))
    assert plot.main([str(copy), "--only", "trajectories"]) == 0
    assert "ended as 'failed (4)'" in capsys.readouterr().err
    assert RunFolder(copy).title.endswith("(failed (4))") and not run.title.endswith(")")
    (copy / "zones.csv").write_text("side,separation\n")
    with pytest.raises(BadInput, match="tools.plot_steady"):
        plot.main([str(copy)])


def test_fields_hold_the_velocity_at_all_its_nodes(freefem, tmp_path):
    """Poiseuille's parabola on a mesh of a few elements across: linear functions on the mesh's own triangles miss it between vertices."""
    assert freefem("cases/poiseuille.edp", "-tend", "0.05", "-fields", "0.05", "-out", tmp_path / "run").returncode == 0
    run = RunFolder(tmp_path / "run")
    mesh, values = run.field(len(run.fields) - 1)
    assert len(mesh.triangles) == 4 * len(run.mesh.triangles)
    low, high = run.mesh.points[:, 1].min(), run.mesh.points[:, 1].max()
    inlet = abs(mesh.points[:, 0] - run.mesh.points[:, 0].min()) < 1e-9
    y, u = mesh.points[inlet, 1], values["velocity"][inlet, 0]
    assert np.allclose(u, u.max() * 4 * (y - low) * (high - y) / (high - low) ** 2, atol=1e-5 * u.max())


def test_a_run_of_contacts_alone_is_left_to_its_own_pictures(freefem, tmp_path):
    assert freefem("cases/falling_particles.edp", "-tend", "0.1", "-out", tmp_path / "run").returncode == 0
    with pytest.raises(BadInput, match="plot_contacts"):
        plot.main([str(tmp_path / "run")])
    done = run_tool("plot_contacts", tmp_path / "run", "--only", "energy")
    assert done.returncode == 0 and done.stderr == "", "a finished run is no reason to warn"


@pytest.mark.parametrize("extent", [(0, 0, 1, 1), (-250, -250, 100, 100), (1000, -500, 1, 1), (0, 0, 4, 1), (-1e-4, 0, 2e-4, 5e-4), (-2, 0, 1, 8), (0, 0, 1, 3), (1000, 0, 1, 3)])
def test_labels_of_ticks_stay_apart_and_in_the_picture(extent, tmp_path):
    figure, axes, bar = panels(6, extent)
    bar.remove()
    for one in axes:
        frame(one, extent, "cm")
    figure.draw_without_rendering()
    boxes = [label.get_window_extent() for one in axes if one.last_row for label in one.get_xticklabels() if label.get_text()]
    assert len(boxes) >= sum(one.last_row for one in axes) and not [1 for k, a in enumerate(boxes) for b in boxes[:k] if a.overlaps(b)]
    picture = plt.imread(save(figure, tmp_path / "panels.png"))
    assert (picture[:, :8, :3] == 1).all() and (picture[:, -8:, :3] == 1).all()  # nothing is cut off


@pytest.mark.parametrize("extent", [(0, 0, 1, 12), (0, 0, 1, 20), (0, 0, 0.1, 3), (0.3, 0, 0.4, 12)])
def test_tall_narrow_scenes_have_ticks_within_and_titles_apart(run, extent, monkeypatch):
    drawn = []
    monkeypatch.setattr(plot, "save", lambda figure, path: drawn.append(figure))
    run.__dict__["extent"] = extent
    plot.plot_fields(run, None)
    drawn[0].draw_without_rendering()
    axes = drawn[0].axes[:6]
    titles = [one.title.get_window_extent() for one in axes]
    assert all(a.x1 < b.x0 for a, b in zip(titles, titles[1:]))
    ticks = [tick for one in axes for tick in one.get_xticks()]
    assert len(ticks) >= 6 and extent[0] <= min(ticks) and max(ticks) <= extent[0] + extent[2]
    plt.close(drawn[0])


@pytest.mark.parametrize("extent", [(0, 0, 1, 12), (0, 0, 1, 30), (0, 0, 12, 1), (0, 0, 30, 1)])
def test_title_and_colour_bar_of_a_film_keep_apart_and_in_the_picture(run, extent, monkeypatch):
    made = []
    monkeypatch.setattr(film, "panels", lambda *given, **more: made.append(panels(*given, **more)) or made[0])
    run.__dict__["extent"] = extent
    next(film.pictures(run, run.frames))
    figure, _, bar = made[0]
    heading = next(text for text in [*figure.texts, figure.axes[0].title] if text.get_text()).get_window_extent()
    words = bar.yaxis.label.get_window_extent()
    assert not heading.overlaps(bar.get_window_extent()) and not heading.overlaps(words)
    for box in (heading, words):
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= figure.bbox.x1 and box.y1 <= figure.bbox.y1
    plt.close(figure)


@pytest.mark.parametrize("draw", ["plot_fields", "plot_trajectories"])
@pytest.mark.parametrize("extent", [(0, 0, 100, 1), (0, 0, 1, 0.3)])
def test_a_colour_bar_is_as_long_as_its_label(run, extent, draw, monkeypatch):
    """Beside a pipe 100 times as long as high it was a tenth of it."""
    drawn = []
    monkeypatch.setattr(plot, "save", lambda figure, path: drawn.append(figure))
    run.__dict__["extent"], run.__dict__["frames"] = extent, run.frames[-1:]
    getattr(plot, draw)(run, None)
    figure, bar = drawn[0], drawn[0].axes[-1]
    figure.draw_without_rendering()
    words, long = bar.yaxis.label.get_window_extent(), bar.get_window_extent()
    assert words.height < long.height and not figure.texts[0].get_window_extent().overlaps(long)
    assert 0 < words.y0 and words.y1 < figure.bbox.y1
    heights = [label.get_window_extent() for label in figure.axes[0].get_yticklabels() if label.get_text()]
    assert heights and not [1 for a, b in zip(heights, heights[1:]) if a.overlaps(b)]
    plt.close(figure)


def test_a_logarithmic_axis_has_two_labels_at_least(folder, tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr(plot, "save", lambda figure, path: seen.append(figure))
    monkeypatch.setattr(plot, "series", lambda run: [("norm", [("", np.linspace(0.05, 0.6, len(run.fluid["t"])))], True)])
    plot.plot_series(RunFolder(folder), tmp_path / "series.png")
    axes, = seen[0].axes
    low, high = axes.get_ylim()
    assert sum(low <= tick <= high for tick in axes.get_yticks()) >= 2 and axes.get_position().width > 0.6
    plt.close(seen[0])


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


def test_carried_particles_without_a_mesh_have_their_walls_their_units_and_no_spokes(tmp_path, monkeypatch):
    """No mesh: the walls are those of walls.csv; spheres that do not turn have no line at an angle of 0; times have the unit of the case."""
    (tmp_path / "run.json").write_text(json.dumps({"case": "drops", "status": "finished", "units": {"-length": "mm", "-delay": "ms"}, "parameters": {}}))
    write_csv(tmp_path / "particles.csv", "step t id x y theta u v omega radius".split(), [[k, 10.0 * k, 0, 2.0 + k, 1.0, 0, 0.1, 0, 0, 0.5] for k in range(4)])
    write_csv(tmp_path / "steps.csv", ["step", "t"], [[k, 10.0 * k] for k in range(4)])
    write_csv(tmp_path / "walls.csv", ["x1", "y1", "x2", "y2"], [[0, 0.5, 9, 0.5]])
    figures = []
    for module in (plot, plot_transport):
        monkeypatch.setattr(module, "save", lambda figure, path: figures.append(figure) or path)
    assert plot.main([str(tmp_path), "--only", "fields", "trajectories"]) == 0
    assert plot_transport.main([str(tmp_path), "--times", "10,30"]) == 0
    assert len(figures) == 4
    for figure in figures:
        for axes in figure.axes:
            lines = [part.get_segments() for part in axes.collections if hasattr(part, "get_segments")]
            assert len(lines) == 1 and len(lines[0]) == 1
            np.testing.assert_array_equal(lines[0][0], [[0, 0.5], [9, 0.5]])
    assert [axes.get_title() for axes in figures[2].axes] == ["t = 10.0 ms: 1 inside", "t = 30.0 ms: 1 inside"]
    for figure in figures:
        plt.close(figure)


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


def test_a_film_of_contacts_has_as_many_frames_as_asked_for(tmp_path):
    """By the option that films of flows have too."""
    from PIL import Image
    write_csv(tmp_path / "particles.csv", "step,t,id,x,y,theta,u,v,omega,radius".split(","), [[k, k, i, i, 1 - 0.1 * k, 0, 0, -0.1, 0, 0.2] for k in range(6) for i in range(2)])
    write_csv(tmp_path / "motion.csv", "step,t,kinetic_energy,potential_energy,worst_gap".split(","), [[k, k, 1, 1, 0.1] for k in range(6)])
    assert plot_contacts.main([str(tmp_path), "--only", "film", "--gif", "--frames", "3"]) == 0
    with Image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == 3
