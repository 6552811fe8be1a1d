"""Pictures of steady flows."""
import re
import shutil

import numpy as np
import pytest

from tests.tables import results_of
from tools.base.command import BadInput
from tools.base.mesh_files import read_field, read_mesh


def test_the_pictures_are_drawn(run_folder, pipe_run):
    from tools.plot import steady as plot_steady
    shutil.copytree(pipe_run, run_folder)
    assert plot_steady.main([str(run_folder)]) == 0
    mesh, (fine, values) = read_mesh(run_folder / "mesh.mesh"), read_field(run_folder / "fields.vtu")
    assert len(fine.triangles) == 4 * len(mesh.triangles) and len(values["velocity"]) == len(fine.points)
    for name in ("streamlines", "speed", "pressure", "walls"):
        assert (run_folder / f"{name}.png").stat().st_size > 5000
    assert not (run_folder / "k.png").exists()
    for name, old, new, words in (("wall.csv", ",-0.1,-1,", ",nan,-1,", "wall.csv, line 2: y is nan"),
        ("run.json", '"-reynolds": ', '"-reynolds": "abc", "-was": ', '-reynolds must be a number, not "abc"'),
                                  ("zones.csv", "separation", "parting", "zones.csv has no column separation")):
        whole = (run_folder / name).read_text()
        assert old in whole
        (run_folder / name).write_text(whole.replace(old, new, 1))
        with pytest.raises(BadInput, match=words):
            plot_steady.main([str(run_folder), "--out", str(run_folder / "none")])
        (run_folder / name).write_text(whole)
    (run_folder / "zones.csv").unlink()
    with pytest.raises(BadInput, match="has no zones.csv"):
        plot_steady.main([str(run_folder), "--out", str(run_folder / "none")])
    assert not (run_folder / "none").exists()


def test_a_laminar_flow_without_tables_of_walls_is_drawn(freefem, tmp_path, capsys):
    """It was refused for a wall.csv, and tools.plot said that nothing can be drawn."""
    from tools.plot import steady as plot_steady
    from tools.plot.resolved import main as plot
    freefem("cases/cavity.edp", "-reynolds", 100, "-fields", 1, "-out", tmp_path / "run")
    assert plot_steady.main([str(tmp_path / "run")]) == 0
    assert capsys.readouterr().out.endswith(": streamlines.png, speed.png, pressure.png\n")
    for name in ("streamlines", "speed", "pressure"):
        assert (tmp_path / "run" / f"{name}.png").stat().st_size > 5000
    with pytest.raises(BadInput, match="python -m tools.plot_steady draws it"):
        plot([str(tmp_path / "run")])


def test_a_tall_narrow_flow_is_drawn(freefem, run_folder, monkeypatch):
    """A strip 27 times as high as long: as many lines as the page holds, on a page of that shape."""
    from tools.plot import steady as plot_steady
    from tools.plot.style import plt
    results_of(freefem, run_folder, "turbulent_channel", "-cells", 40, "-model", "laminar", "-retau", 20)
    drawn, asked = plt.Axes.streamplot, []
    labels = []
    monkeypatch.setattr(plt, "close", lambda figure: labels.extend(word for one in figure.axes for word in (one.get_xlabel(),
        one.get_ylabel())))
    monkeypatch.setattr(plt.Axes, "streamplot", lambda *given, density, **more: asked.append(density) or drawn(*given,
        density=np.minimum(density, 7), **more))
    assert plot_steady.main([str(run_folder)]) == 0
    assert np.max(asked) < 7
    labels = [re.sub(r"\$10\^\{-?\d+\}\$ ", "", word) for word in labels]  # with a power of ten, as the values want it
    assert {"x (L)", "y (L)", "speed (L/T)", "gauge pressure (M/(L T$^2$))"} <= set(labels) and not [word for word in labels
        if "m" in word.partition(" (")[2] or "Pa)" in word]
    high, wide = plt.imread(run_folder / "speed.png").shape[:2]
    assert high > 1.5 * wide
    file = run_folder / "wall.csv"  # as it is between planes of symmetry
    file.write_text(file.read_text().splitlines()[0] + "\n")
    assert plot_steady.main([str(run_folder), "--out", str(run_folder / "none")]) == 0
    assert {one.name for one in (run_folder / "none").iterdir()} == {"streamlines.png", "speed.png", "pressure.png"}
