"""Films of runs: frames, formats, titles."""
from types import SimpleNamespace

import numpy as np
import pytest

from tools.plot import film
from tools.plot.film import frame_rate, make_film, mp4_possible
from tools.plot.in_time import FieldsInTime, film_times
from tools.plot.style import panels, plt


def test_the_film_has_as_many_frames_as_asked_for(run, tmp_path):
    if not mp4_possible():
        pytest.skip("no ffmpeg here: the film is a gif")
    import imageio_ffmpeg
    path = make_film(run, tmp_path, most=9)
    frames, _ = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert path.name == "film.mp4" and frames == 9


def test_a_gif_where_no_mp4_can_be_made(run, tmp_path):
    from PIL import Image
    path = make_film(run, tmp_path, most=4, gif=True)
    with Image.open(path) as film:
        assert path.name == "film.gif" and film.n_frames == 4


def test_film_speed():
    assert frame_rate(10) == 4 and frame_rate(120) == 10 and frame_rate(3000) == 25


@pytest.mark.parametrize("extent", [(0, 0, 1, 12), (0, 0, 1, 30), (0, 0, 12, 1), (0, 0, 30, 1)])
def test_title_and_colour_bar_of_a_film_keep_apart_and_in_the_picture(run, extent, monkeypatch):
    made = []
    monkeypatch.setattr(film, "panels", lambda *given, **more: made.append(panels(*given, **more)) or made[0])
    run.__dict__["extent"] = extent
    next(film.pictures(run, [t for t, _ in run.frames]))
    figure, _, bar = made[0]
    heading = next(text for text in [*figure.texts, figure.axes[0].title] if text.get_text()).get_window_extent()
    words = bar.yaxis.label.get_window_extent()
    assert not heading.overlaps(bar.get_window_extent()) and not heading.overlaps(words)
    for box in (heading, words):
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= figure.bbox.x1 and box.y1 <= figure.bbox.y1
    plt.close(figure)


@pytest.mark.parametrize("extent", [(0, -0.0125, 0.06, 0.025), (0, -1.25e-3, 6e-3, 2.5e-3), (0, -12500, 60000, 25000)])
def test_labels_of_a_film_are_whole(run, extent, monkeypatch):
    """Numbers with many figures pushed the name of the ordinate out of the picture, whose size a film does not fit to them."""
    made = []
    monkeypatch.setattr(film, "panels", lambda *given, **more: made.append(panels(*given, **more)) or made[0])
    run.__dict__["extent"] = extent
    shots = film.pictures(run, [t for t, _ in run.frames])
    sizes = {next(shots).shape, next(shots).shape}
    figure, (axes,), _ = made[0]
    name = axes.yaxis.label.get_window_extent()
    ticks = [label.get_window_extent() for label in axes.get_yticklabels() if label.get_text()]
    assert len(sizes) == 1 and name.x0 >= 0 and max(len(label.get_text()) for label in axes.get_yticklabels()) >= 4
    assert ticks and not any(name.overlaps(tick) for tick in ticks)
    plt.close(figure)


def snapshots(*meshes):
    """A stand-in of a run with fields 0, 10, 20, ... at t = 0, 1, 2, ..., on these numbers of triangles."""
    def field(k):
        triangles = np.zeros((meshes[k], 3), int)
        return SimpleNamespace(points=np.zeros((3, 2)), triangles=triangles), {"velocity": np.full((3, 2), 10.0 * k)}
    return SimpleNamespace(fields=[(float(k), None) for k in range(len(meshes))], field=field)


def test_fields_between_two_files_are_linear_in_time():
    fields = FieldsInTime(snapshots(1, 1, 2))
    found = [fields.at(t)[1]["velocity"][0, 0] for t in (-1, 0, 0.25, 1 - 1e-9, 1, 1.4, 1.6, 5)]
    assert found == [0, 0, 2.5, 10, 10, 10, 20, 20]  # another mesh: the nearer one
    assert len(fields.read) <= 2


def test_bodies_move_between_the_fields_of_a_film(run, tmp_path):
    """A film of nine fields had nine pictures, though the bodies are known at a hundred times."""
    times = film_times(run)
    assert len(run.fields) == 9 and len(times) == 101 and np.allclose(times, np.linspace(0, 1, 101))
    run.__dict__["frames"] = [(0.0, 0), (0.5, 4)]
    assert film_times(run)[-1] == pytest.approx(0.5) and len(film_times(run)) == 51  # no field is there behind the last one
    run.__dict__["particles"] = {name: values[:0] for name, values in run.particles.items()}
    assert list(film_times(run)) == [0, 0.5]


def test_bodies_of_a_film_have_colours_and_a_bar(run, monkeypatch):
    made = []
    monkeypatch.setattr(film, "panels", lambda *given, **more: made.append(panels(*given, **more)) or made[-1])
    shots = [next(film.pictures(run, [0.8], colour=colour)) for colour in (None, "size")]
    assert shots[0].shape != shots[1].shape or (shots[0] != shots[1]).any()
    words = [axes.get_ylabel() for axes in made[1][0].axes]
    assert "velocity magnitude (m/s)" in words and "diameter (m)" in words
    for figure, *_ in made:
        plt.close(figure)
