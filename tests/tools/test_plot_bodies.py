"""Pictures of bodies: their colours, held ones, outlines, force chains; words of figures that find their place."""
import json

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from tests.conftest import run_tool
from tests.synthetic import write_csv, write_run
from tools.base.command import BadInput
from tools.base.mesh_files import SIDES
from tools.base.run_folder import RunFolder
from tools.meshing.labels import NAMES
from tools.plot import captions, colour, overlays, resolved as plot, series as timeline, style
from tools.plot.style import frame, panels, plt, time_text


@pytest.fixture
def bodies(tmp_path):
    """A made-up run of four bodies without fields, of which the first is held and the others have two densities."""
    folder = write_run(tmp_path / "run", number=4, steps=20, t_end=0.8)
    write_csv(folder / "entries.csv", ["t", "id", "x", "y", "u", "v", "radius", "density", "free"],
        [[0, k, 0, 0, 0, 0, 0.01, 2 + k // 2, k > 0] for k in range(4)])
    return RunFolder(folder)


def drawn(monkeypatch, module):
    """The figures that a module would save."""
    kept = []
    monkeypatch.setattr(module, "save", lambda figure, path: kept.append(figure) or path)
    return kept


def test_bodies_are_filled_by_what_is_asked_for(bodies):
    here = bodies.particles_at(0.6)
    ids = here[0].astype(int)
    for name, values, label in (("density", 2 + ids // 2, "density (kg/m$^3$)"), ("id", ids, "id of the body"),
            ("size", 2 * here[4], "diameter (m)")):
        look = colour.Look(bodies, name)
        faces, held = look.at(here, 0.6)
        assert look.label == label and np.allclose(faces, plt.get_cmap("plasma")(look.scale(values)))
        assert held.tolist() == [one == 0 for one in ids]
    assert colour.Look(bodies, "speed").label == "speed of the bodies (m/s)"
    assert colour.speed_at(bodies, ids, 0.6) == pytest.approx(0.9)


def test_a_value_of_all_bodies_stands_in_the_title(bodies, monkeypatch):
    for track in bodies.tracks.values():
        track["radius"][:] = 0.01
    figures = drawn(monkeypatch, plot)
    plot.plot_fields(bodies, None, colour="size", times=[0.6])
    assert figures[0].texts[0].get_text() == "pipe obstacles: particles (diameter 0.02 m, hatched: held)"
    assert len(figures[0].axes) == 1  # no colour bar
    plt.close(figures[0])


def test_held_bodies_are_hatched_in_every_picture(bodies, monkeypatch):
    for module, make in ((plot, plot.plot_trajectories), (plot, lambda run, path: plot.plot_fields(run, path, times=[0.1])),
            (overlays, overlays.plot_chains), (overlays, lambda run, path: overlays.plot_outlines(run, path, [0.02, 0.1]))):
        figures = drawn(monkeypatch, module)
        make(bodies, None)
        hatched = [one for axes in figures[0].axes for one in axes.collections if getattr(one, "get_hatch", lambda: None)()]
        assert hatched and figures[0].texts[0].get_text().endswith("hatched: held)"), make
        plt.close(figures[0])


def test_outlines_stand_at_each_of_the_times(bodies, monkeypatch):
    figures = drawn(monkeypatch, overlays)
    overlays.plot_outlines(bodies, None, [0.3, 0.5, 0.7])
    axes, bar = figures[0].axes
    rims = [one for one in axes.collections if type(one).__name__ == "PatchCollection" and not one.get_hatch()]
    assert [len(one.get_paths()) for one in rims] == [np.sum(bodies.particles_at(t)[0] > 0) for t in (0.3, 0.5, 0.7)]
    assert len({tuple(one.get_edgecolor()[0]) for one in rims}) == 3
    assert [label.get_text() for label in bar.get_yticklabels()] == ["0.3", "0.5", "0.7"]
    plt.close(figures[0])


def test_chains_are_the_forces_of_the_step_between_the_bodies(tmp_path, monkeypatch):
    row = "step t id x y theta u v omega radius".split()
    write_csv(tmp_path / "particles.csv", row, [[k, 0.1 * k, i, 0.2 + 0.2 * i, 0.5, 0, 0, 0, 0, 0.1] for k in (1, 2)
        for i in (0, 1)])
    write_csv(tmp_path / "contacts.csv", "t i j gap nx ny impulse".split(), [[0.1, 0, 1, 0, -1, 0, 3], [0.2, 0, 1, 0, -1, 0, 0.5],
        [0.2, 0, -1, 0.1, 1, 0, 0.25]])
    write_csv(tmp_path / "fluid.csv", ["step", "t", "dt"], [[1, 0.1, 0.1], [2, 0.2, 0.05]])
    figures = drawn(monkeypatch, overlays)
    run = RunFolder(tmp_path)
    overlays.plot_chains(run, None)
    overlays.plot_chains(run, None, [0.0, 0.11, 0.2])  # the rows nearest to them
    lines = [[one for one in axes.collections if type(one).__name__ == "LineCollection" and one.get_array() is not None]
        for figure in figures for axes in figure.axes[:-1]]
    assert [one[0].get_array().tolist() for one in lines] == [[10, 5], [30], [10, 5]]
    assert np.allclose(lines[0][0].get_segments()[0], [[0.2, 0.5], [0.4, 0.5]])
    assert np.allclose(lines[0][0].get_segments()[1], [[0.2, 0.5], [0.0, 0.5]])  # to the wall
    assert figures[1].axes[-1].get_ylabel() == "normal force per depth (N/m)"
    for figure in figures:
        plt.close(figure)


def test_a_power_of_ten_stands_in_the_label_and_not_beside_it(tmp_path):
    figure, axes = plt.subplots(1, 3)
    for one, top, label in zip(axes, (3e5, 2.0, 4e-6), ("pressure (mg/(mm s$^2$))", "flux (m/s)", "")):
        one.plot([0, 1], [0, top])
        one.set_ylabel(label)
    captions.fold_powers(figure)
    assert [one.get_ylabel() for one in axes] == ["pressure ($10^{5}$ mg/(mm s$^2$))", "flux (m/s)", ""]
    assert [one.yaxis.offsetText.get_visible() for one in axes] == [False, True, True]  # without a label it is all there is
    assert captions.with_power("number", 4) == "number ($10^{4}$)"
    plt.close(figure)


@pytest.mark.parametrize("extent, number", [((0, 0, 1, 0.2), 6), ((0, 0, 1, 3), 3), ((0, 0, 1, 1), 1), ((0, 0, 1, 12), 1)])
def test_titles_are_over_the_panels_and_whole(extent, number):
    for words in ("pipe: particles", "a case of a long name: velocity and particles (hatched: held)"):
        figure, axes, bar = panels(number, extent)
        captions.headline(figure, words)
        box, width = figure.texts[0].get_window_extent(figure.canvas.get_renderer()), figure.bbox.width
        middle = 0.5 * (axes[0].get_position().x0 + max(one.get_position().x1 for one in axes)) * width
        if box.width < 0.5 * min(middle, width - middle):
            assert 0.5 * (box.x0 + box.x1) == pytest.approx(middle, abs=1)
        if box.width < 0.98 * width:
            assert box.x0 >= 0 and box.x1 <= width
        plt.close(figure)


def test_long_labels_have_two_lines():
    figure, axes = plt.subplots()
    captions.fit_label(axes, "pressure drop (mg/(mm s$^2$))", 1.4)
    assert axes.get_ylabel() == "pressure drop\n(mg/(mm s$^2$))"
    captions.fit_label(axes, "flux (mm$^2$/s)", 1.4)
    assert axes.get_ylabel() == "flux (mm$^2$/s)"
    plt.close(figure)


def test_the_flux_through_each_outlet_is_a_curve(bodies):
    panel = timeline.series(bodies)[0]
    assert [name for name, _ in panel[1]] == ["inlet", "outlet", "right"] and panel[0] == "flux (m$^2$/s)"
    assert np.allclose(panel[1][1][1], 3 * panel[1][2][1])
    table = bodies.table("fluxes")
    one = table["label"] != 12
    write_csv(bodies.folder / "fluxes.csv", table, np.column_stack([values[one] for values in table.values()]))
    assert [name for name, _ in timeline.series(RunFolder(bodies.folder))[0][1]] == ["inlet", "outlet"]
    info = {**bodies.info, "labels": {"moving": [1]}, "sides": {"12": "drain"}}
    (bodies.folder / "run.json").write_text(json.dumps(info))
    write_csv(bodies.folder / "fluxes.csv", table, np.column_stack([*(table[name] for name in ("t", "label", "flux"))]))
    run = RunFolder(bodies.folder)
    assert [name for name, _ in timeline.outlets(run)] == ["outlet", "drain"]
    run.info["labels"]["moving"] = [1, 12]
    assert timeline.outlets(run) == []
    assert {number: NAMES[number] for number in SIDES} == SIDES
    names = ["inlet", "feed pipe", "right arm", "drain"]
    assert [timeline.beside(names, signs) for signs in (50, 38, 5)] == [3, 2, 1]


def test_legends_end_within_their_panels(bodies, monkeypatch):
    t = bodies.fluid["t"]
    curves = [("x", [(name, t) for name in names], False) for names in (["sphere 0", "sphere 1", "sphere 2"], ["inlet", "outlet"],
        ["particles inside", "contacts"], ["inlet", "feed pipe", "right arm", "drain"])]
    monkeypatch.setattr(timeline, "series", lambda run: curves)
    figures = drawn(monkeypatch, timeline)
    timeline.plot_series(bodies, None)
    figures[0].draw_without_rendering()
    for axes in figures[0].axes:
        legend, room = axes.get_legend().get_window_extent(), axes.get_window_extent()
        assert room.x0 < legend.x0 and legend.x1 < room.x1
    plt.close(figures[0])


def test_hatches_and_radii_are_seen_on_every_colour(bodies):
    look = colour.Look(bodies, "density")
    here = bodies.particles_at(0.6)
    for density, seen in ((0.0, "PALE"), (1.0, "BODY_EDGE")):
        faces = plt.get_cmap("plasma")(np.full(len(here[0]), density))
        figure, (axes,), _ = panels(1, bodies.extent)
        style.particle_artists(axes, here, look=(faces, look.at(here, 0.6)[1]))
        pen = to_rgba(getattr(style, seen))
        hatched = [one for one in axes.collections if one.get_hatch()]
        assert len(hatched) == 1 and np.allclose(hatched[0].get_edgecolor()[0], pen)
        assert np.allclose(axes.collections[-1].get_colors(), pen)
        plt.close(figure)


def test_no_panel_is_empty(bodies, monkeypatch):
    table = bodies.fluid
    table["worst_gap"][:], table["contacts"][:], table["particles"][:] = 1e-3, 0, 4
    names = [panel[0] for panel in timeline.series(bodies)]
    assert "number" not in names and "worst overlap / radius" not in names and len(names) == 3
    figures = drawn(monkeypatch, timeline)
    timeline.plot_series(bodies, None)
    figures[0].draw_without_rendering()
    boxes = [axes.get_position() for axes in figures[0].axes]
    assert len(boxes) == 3 and boxes[2].width > 1.8 * boxes[0].width  # the odd one takes the row
    assert all(axes.lines and axes.get_xlabel() for axes in figures[0].axes)
    plt.close(figures[0])


@pytest.mark.parametrize("words, said", [(["--times", "0.2", "9"], "9 is not between"),
    (["--colour", "density"], "tells the density"), (["--streamlines", "--only", "fields"], "wrote no fields")])
def test_what_a_run_does_not_tell_is_refused_in_one_line(tmp_path, words, said):
    folder = write_run(tmp_path / "run", number=2, steps=4)
    done = run_tool("plot", folder, "--no-film", *words)
    assert done.returncode == 3 and said in done.stderr and done.stderr.count("\n") == 1


def test_forces_need_the_length_of_a_step(bodies):
    bodies.info["parameters"].pop("-dt")
    bodies.fluid.pop("dt")
    with pytest.raises(BadInput, match="no table tells the length of the step"):
        overlays.plot_chains(bodies, None)


@pytest.mark.parametrize("high, names", [(0.05, 1), (0.6, 3)])
def test_names_of_ordinates_of_long_thin_panels_do_not_overlap(high, names):
    """In a slit of 40 by 2 micrometres the names of three panels lay on each other."""
    extent = (0, 0, 1e-5, high * 1e-5)
    figure, axes, _ = panels(3, extent)
    for one in axes:
        frame(one, extent, "m")
    captions.fold_powers(figure)
    captions.thin_labels(figure)
    kept = [one.yaxis.label.get_window_extent() for one in axes if one.get_ylabel()]
    assert len(kept) == names and all("10^{-" in one.get_ylabel() for one in axes if one.get_ylabel())
    assert not any(one.overlaps(other) for one, other in zip(kept, kept[1:]))
    plt.close(figure)


@pytest.mark.parametrize("t, last, text", [(1e-6, 2e-6, "t = 1.00e-06 s"), (0, 2e-6, "t = 0.00e-06 s"), (0.25, 2, "t = 0.25 s"),
    (1.5e9, 3.1e9, "t = 1.50e+09 s"), (0.002, 0.01, "t = 0.0020 s"), (1250, 5000, "t = 1250 s"), (1e-7, None, "t = 1e-07 s")])
def test_times_in_titles_have_few_figures(t, last, text):
    assert time_text(t, "s", last) == text


def test_chains_without_contacts_have_no_colour_bar(tmp_path, monkeypatch):
    folder = write_run(tmp_path / "run", number=3, steps=4)
    write_csv(folder / "contacts.csv", "t i j gap nx ny impulse".split(), [[5.0, 0, 1, 0, 1, 0, 1e-3]])  # at no row below
    figures = drawn(monkeypatch, overlays)
    overlays.plot_chains(RunFolder(folder), None, [0.0, 0.5])
    assert not any(getattr(axes, "is_bar", False) for axes in figures[0].axes)
    assert all("no contact" in axes.get_title() for axes in figures[0].axes)
    plt.close(figures[0])
