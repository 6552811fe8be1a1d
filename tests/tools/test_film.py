"""Films of runs: frames, formats, titles."""
import pytest

from tools.plot import film
from tools.plot.film import frame_rate, make_film, mp4_possible
from tools.plot.style import panels, plt


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


def test_film_speed():
    assert frame_rate(10) == 4 and frame_rate(120) == 10 and frame_rate(3000) == 25


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
