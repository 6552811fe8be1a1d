"""tools.plot: what is drawn, and from what."""
import json
import subprocess
import sys

import numpy as np
import pytest

from tests.conftest import run_tool
from tests.synthetic import ROOT, write_csv, write_run
from tools.base.command import BadInput
from tools.base.mesh_files import chains
from tools.base.run_folder import RunFolder
from tools.base.tables import read_table
from tools.plot import resolved as plot, series as timeline
from tools.plot.style import draw_outline, frame, panels, plt, save, speed_top


def test_all_pictures_are_made(folder, tmp_path, capsys):
    assert plot.main([str(folder), "--out", str(tmp_path / "new" / "figures"), "--frames", "9"]) == 0
    said = capsys.readouterr().out
    out = tmp_path / "new" / "figures"
    for name in ("fields.png", "trajectories.png", "series.png"):
        assert (out / name).stat().st_size > 10_000 and str(out / name) in said
        picture = plt.imread(out / name)
        assert picture.shape[1] > 1000 and picture[:, :, :3].std() > 0.02  # not blank
    films = list(out.glob("film.*"))
    assert len(films) == 1 and films[0].stat().st_size > 5_000
    assert not list(out.glob("*part*"))


def test_sides_that_are_no_walls_are_dashed(run):
    figure, axes = plt.subplots()
    draw_outline(axes, run.mesh, (3,))
    dashed = [line for line in axes.collections if line.get_linestyle()[0][1] is not None]
    plt.close(figure)
    assert len(dashed) == 1 and len(dashed[0].get_segments()) == len(list(chains(run.mesh.edges[run.mesh.labels == 3])))


def test_a_run_without_fields_or_mesh_is_drawn_from_its_particles(tmp_path, capsys):
    folder = write_run(tmp_path / "run", steps=20)
    assert plot.main([str(folder), "--frames", "5"]) == 0
    assert (folder / "fields.png").is_file() and (folder / "trajectories.png").is_file()
    assert "fields.png (particles only: the run wrote no velocity" in capsys.readouterr().out
    write_csv(folder / "steps.csv", ["step", "t"], [[k, 0.1 * k] for k in range(11)])  # of a transport run
    assert plot.main([str(folder), "--only", "fields"]) == 0
    assert "fields.png (particles only: python -m tools.plot_transport draws the flow" in capsys.readouterr().out


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
    (tmp_path / "particles.csv").write_text(head
        + "0,0,4,7.05,0.5,0,1,0,0,0.1\n0,0,5,-0.05,-0.02,0,1,0,0,0.1\n1,1,4,6.75,0.5,0,1,0,0,0.1\n1,1,5,-0.05,0.98,0,1,0,0,0.1\n")
    run = RunFolder(tmp_path)
    run.__dict__["extent"] = (1.0, 0.0, 2.0, 1.0)  # as a mesh has it
    rows = run.particles_at(0.0).T
    assert np.allclose(sorted(map(tuple, rows[:, :3])), sorted([(4, 1.05, 0.5), (4, 3.05, 0.5), (5, 1.95, 0.98), (5, 1.95, -0.02)]))
    assert np.allclose(run.particles_at(0.5)[:3, 0], [4, 2.9, 0.5])  # half way
    assert run.clip == run.extent
    pieces = plot.broken(run.tracks[4], run.extent, run.period)  # both reach over the seam at x = 1 and 3
    assert [piece[:, 0].tolist() for piece in pieces] == [pytest.approx([1.05, 0.75]), pytest.approx([3.05, 2.75])]
    assert [len(piece) for piece in plot.broken({"x": np.array([1.2, 2.4, 3.4, 3.6, 2.8]), "y": np.full(5, 0.5)}, run.extent,
        (2, 0))] == [3, 4, 2]


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
    for units, names in (({"-rho": "mg/mm3", "-dt": "s"}, ("mm", "mg")), ({"-rhof": "ng/um3", "-mu": "ng/(um ms)"}, ("um", "ng")),
        ({"-length": "m", "-penalty": "m s/kg"}, ("m", "kg")), ({"-reynolds": "", "-dt": "s", "-contact-tol": "mean radii"},
            ("L", "M")), ({"-reynolds": "", "-outlet": "H", "-inlet": "h"}, ("L", "M")), ({"-mu": "Pa s"}, ("m", "kg"))):
        (folder / "run.json").write_text(json.dumps({"case": "mine", "units": units}))
        assert (RunFolder(folder).units["length"], RunFolder(folder).units["mass"]) == names


@pytest.mark.parametrize("units, declared, names", [
    ({"-diameter": "mm", "-ratio": "", "-dt": "s"}, None, ("mm", "M", "s")),  # was kg/(mm s2)
    ({"-diameter": "mm", "-restitution-speed": "m/s"}, None, ("mm", "M", "s")),  # the driver's own
    ({"-diameter": "um", "-length": "m", "-mu": "Pa s"}, None, ("L", "kg", "s")),  # which of both the tables have is not told
    ({"-size": "cm"}, None, ("cm", "M", "s")),
    ({"-diameter": "um", "-length": "m"}, {"length": "mm", "mass": "ug", "time": "ms"}, ("mm", "ug", "ms"))])
def test_units_are_not_mixed_by_guess(tmp_path, units, declared, names):
    (tmp_path / "run.json").write_text(json.dumps({"case": "mine", "units": units, "base_units": declared}))
    run = RunFolder(tmp_path)
    assert (run.units["length"], run.units["mass"], run.units["time"]) == names
    assert run.units_per_depth["pressure"] == "{1}/({0} {2}$^2$)".format(*names)


@pytest.mark.parametrize("words", [["nothing"], [], ["tools"], ["tools", "--frames", "1"], ["tools", "--only", "all"]])
def test_bad_input_is_one_line_and_status_3(words):
    done = run_tool("plot", *words)
    assert done.returncode == 3 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1


@pytest.mark.parametrize("tool", ["plot", "check", "study", "validate"])
def test_every_tool_has_help(tool):
    done = subprocess.run([sys.executable, "-m", f"tools.{tool}", "--help"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0 and f"python -m tools.{tool}" in done.stdout


def test_the_names_of_the_series_are_no_longer_than_their_axes(tmp_path, monkeypatch):
    folder, drawn = write_run(tmp_path / "run", steps=20), []
    table = read_table(folder / "fluid.csv")
    write_csv(folder / "fluid.csv", [*table, "top_speed"], np.column_stack([*table.values(), np.ones(21)]))
    monkeypatch.setattr(timeline, "save", lambda figure, path: drawn.append(figure))
    timeline.plot_series(RunFolder(folder), None)
    drawn[0].canvas.draw()
    assert len(drawn[0].axes) == 6
    for one in drawn[0].axes:
        assert one.yaxis.label.get_window_extent().height <= one.get_window_extent().height
    plt.close(drawn[0])


def test_a_series_of_one_row_is_a_mark(tmp_path, monkeypatch):
    write_csv(tmp_path / "fluid.csv", ["t", "flux_in", "flux_out", "kinetic_energy"], [[0.5, -1, 1, 2]])
    drawn = []
    monkeypatch.setattr(timeline, "save", lambda figure, path: drawn.append(figure))
    timeline.plot_series(RunFolder(tmp_path), None)
    lines = [line for one in drawn[0].axes for line in one.lines]
    assert len(lines) == 3 and all(line.get_marker() == "." for line in lines)
    plt.close(drawn[0])


def test_a_flow_without_particles_has_no_panels_of_them(tmp_path):
    folder = write_run(tmp_path / "run", steps=20)
    table = read_table(folder / "fluid.csv")
    assert {"number", "worst overlap / radius"} < {panel[0] for panel in timeline.series(RunFolder(folder))}
    for name in ("particles", "contacts"):
        table[name][:] = 0
    write_csv(folder / "fluid.csv", table, np.column_stack([*table.values()]))
    assert [panel[0] for panel in timeline.series(RunFolder(folder))] == ["flux (m$^2$/s)", "pressure drop (Pa)",
        "kinetic energy (J/m)"]


def test_what_rounding_lets_through_a_turning_cylinder_is_no_flux(run, monkeypatch):
    table = {name: values.copy() for name, values in run.fluid.items()}
    table["top_speed"] = 1 + 0 * table["t"]
    for factor in (1, 2e-17):
        table["flux_in"], table["flux_out"] = factor * table["flux_in"], factor * table["flux_out"]
        monkeypatch.setitem(run.__dict__, "fluid", table)
        assert ("flux (m$^2$/s)" in [panel[0] for panel in timeline.series(run)]) == (factor == 1)


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


def test_a_fixed_particle_has_no_path_that_counts(tmp_path, monkeypatch):
    folder, drawn = write_run(tmp_path / "run", number=3, steps=20), []
    table = read_table(folder / "particles.csv")
    for name, value in (("radius", 0.01), ("x", 0.5), ("y", 0.0)):
        table[name][table["id"] == 1] = value
    write_csv(folder / "particles.csv", table, np.column_stack([*table.values()]))
    monkeypatch.setattr(plot, "save", lambda figure, path: drawn.append(figure))
    for free, number in ((1, 3), (0, 2)):
        write_csv(folder / "entries.csv", "t,id,x,y,u,v,radius,density,free".split(","), [[0, one, 0, 0, 0, 0, 0.01, 1,
            one != 1 or free] for one in range(3)])
        plot.plot_trajectories(RunFolder(folder), None)
        assert drawn[-1].texts[0].get_text().endswith(f"paths of {number} particles{'' if free else ' (hatched: held)'}")
        plt.close(drawn[-1])


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


def test_a_steady_flow_is_sent_to_its_own_tool(tmp_path, capsys):
    """One without fields had five lines of what was left out first."""
    (tmp_path / "run.json").write_text('{"case": "cylinder_steady", "status": "finished"}')
    (tmp_path / "results.csv").write_text("quantity,value,unit\ndrag_coefficient,5.57,\n")
    with pytest.raises(BadInput, match="its numbers stand in results.csv, and -fields 1 writes"):
        plot.main([str(tmp_path)])
    (tmp_path / "fields.vtu").write_text("")
    with pytest.raises(BadInput, match="is a steady flow; python -m tools.plot_steady draws it"):
        plot.main([str(tmp_path)])
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("extent", [(0, 0, 1, 1), (-250, -250, 100, 100), (1000, -500, 1, 1), (0, 0, 4, 1), (-1e-4, 0, 2e-4, 5e-4),
    (-2, 0, 1, 8), (0, 0, 1, 3), (1000, 0, 1, 3)])
def test_labels_of_ticks_stay_apart_and_in_the_picture(extent, tmp_path):
    figure, axes, bar = panels(6, extent)
    bar.remove()
    for one in axes:
        frame(one, extent, "cm")
    figure.draw_without_rendering()
    boxes = [label.get_window_extent() for one in axes if one.last_row for label in one.get_xticklabels() if label.get_text()]
    assert len(boxes) >= sum(one.last_row for one in axes) and not [1 for k, a in enumerate(boxes) for b in boxes[:k]
        if a.overlaps(b)]
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
    monkeypatch.setattr(timeline, "save", lambda figure, path: seen.append(figure))
    monkeypatch.setattr(timeline, "series", lambda run: [("norm", [("", np.linspace(0.05, 0.6, len(run.fluid["t"])))], True)])
    timeline.plot_series(RunFolder(folder), tmp_path / "series.png")
    axes, = seen[0].axes
    low, high = axes.get_ylim()
    assert sum(low <= tick <= high for tick in axes.get_yticks()) >= 2 and axes.get_position().width > 0.6
    plt.close(seen[0])


@pytest.mark.parametrize("show", ["vorticity", "stream"])
def test_vorticity_and_streamlines_are_drawn(freefem, tmp_path, show, monkeypatch):
    freefem("cases/poiseuille.edp", "-dt", 0.1, "-tend", 20, "-fields", 10, "-out", tmp_path / "run")
    kept = []
    monkeypatch.setattr(plot, "save", lambda figure, path: kept.append(figure) or path)
    plot.plot_fields(RunFolder(tmp_path / "run"), tmp_path / "a.png", number=1, show=show)
    figure = kept[0]
    label, field = figure.axes[-1].get_ylabel(), figure.axes[0].collections[0]
    low, high = field.get_clim()
    assert label == {"vorticity": "vorticity (1/s)", "stream": "stream function (m$^2$/s)"}[show]
    lines = [one for one in figure.axes[0].collections if type(one).__name__ == "TriContourSet"]
    if show == "vorticity":
        assert low == -high and 0.5 < high and not lines
    else:  # the flux between the plates is 2/3 m2/s of the parabola
        assert low == pytest.approx(0, abs=0.01) and high == pytest.approx(2 / 3, rel=0.02) and len(lines) == 1
    plt.close(figure)


def test_what_the_fields_do_not_hold_is_said(folder):
    done = run_tool("plot", folder, "--only", "fields", "--show", "vorticity")
    assert done.returncode == 3 and "hold no vorticity" in done.stderr and done.stderr.count("\n") == 1
