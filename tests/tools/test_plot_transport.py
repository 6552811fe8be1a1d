"""tools.plot_transport: times, units and walls of carried particles."""
import json

import numpy as np
import pytest
from matplotlib.collections import PatchCollection, PathCollection

from tests.synthetic import write_csv, write_run
from tools.base.command import BadInput
from tools.plot import resolved as plot, transport as plot_transport
from tools.plot.style import DOT, plt


@pytest.mark.parametrize("times", ["inf", "nan", "-0.1", "0.2,1.1"])
def test_times_of_a_transport_run_lie_within_it(tmp_path, times):
    write_run(tmp_path, steps=10)
    write_csv(tmp_path / "steps.csv", ["step", "t"], [[k, 0.1 * k] for k in range(11)])
    assert plot_transport.main([str(tmp_path), "--times=0,1", "--out", str(tmp_path / "out")]) == 0
    with pytest.raises(BadInput, match="is not between 0 and 1 s"):
        plot_transport.main([str(tmp_path), f"--times={times}"])


def test_carried_particles_without_a_mesh_have_their_walls_their_units_and_no_spokes(tmp_path, monkeypatch):
    """No mesh: the walls are those of walls.csv; spheres that do not turn have no line at an angle of 0; times have the unit of the
    case."""
    (tmp_path / "run.json").write_text(json.dumps({"case": "drops", "status": "finished", "units": {"-length": "mm",
        "-delay": "ms"}, "parameters": {}}))
    write_csv(tmp_path / "particles.csv", "step t id x y theta u v omega radius".split(), [[k, 10.0 * k, 0, 2.0 + k, 1.0, 0, 0.1,
        0, 0, 0.5] for k in range(4)])
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


def test_what_is_too_small_to_be_seen_is_a_dot_in_every_picture(tmp_path, monkeypatch):
    """A grain of 0.1 mm in 0.3 m had less than a pixel in tools.plot; a ball among them keeps its size, and colours stay."""
    (tmp_path / "run.json").write_text(json.dumps({"case": "grains", "status": "finished", "parameters": {}}))
    write_csv(tmp_path / "particles.csv", "step t id x y theta u v omega radius".split(), [[k, 0.1 * k, one, 0.1 * one,
        0.1 + 0.01 * k, 0, 0.1 * one, 0, 0, radius] for k in range(3) for one, radius in enumerate((1e-4, 1e-4, 0.02))])
    write_csv(tmp_path / "steps.csv", ["step", "t"], [[k, 0.1 * k] for k in range(3)])
    figures = []
    for module in (plot, plot_transport):
        monkeypatch.setattr(module, "save", lambda figure, path: figures.append(figure) or path)
    assert plot.main([str(tmp_path), "--only", "fields", "trajectories", "--colour", "speed"]) == 0
    assert plot_transport.main([str(tmp_path), "--times", "0.1,0.2"]) == 0
    for figure in figures:
        title = figure.texts[-1].get_text()
        assert "dots" in title, title
        for axes in (one for one in figure.axes if not getattr(one, "is_bar", False)):
            dots, = (part for part in axes.collections if isinstance(part, PathCollection))
            assert len(dots.get_offsets()) == 2 and dots.get_sizes() == [DOT**2]
            assert len({tuple(shade) for shade in dots.get_facecolors()}) == (2 if figure is figures[0] else 1)
            assert sum(len(part.get_paths()) for part in axes.collections if isinstance(part, PatchCollection)) == 1
        plt.close(figure)
