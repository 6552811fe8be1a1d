"""A film of velocity and particles: mp4 through imageio-ffmpeg, else a gif through Pillow.

Drawn by python -m tools.plot RUN --only film.

make_film(run, out) -> path. One frame per field file, or per row of the tables where bodies
move and there are more rows than fields: the fields between two files are then linear in time
(in_time.py). Thinned to `most`; the colour scale is one for the whole film.
"""
from pathlib import Path

import numpy as np

from tools.base.command import BadInput
from tools.base.run_folder import own
from tools.plot.captions import centre, contain, fold_powers, second_bar
from tools.plot.colour import Look
from tools.plot.in_time import FieldsInTime, film_times
from tools.plot.style import (MARGINS, TWO_BARS, draw_boundary, draw_particles, draw_speed, draw_streamlines, fitting, frame,
    label_of, lowest_with, panels, plt, scale_of, shown_of, time_text)

DPI = 160


def thinned(run, frames, most):
    """The frames of a film, at most so many of those that the run has."""
    if len(frames) < 2:
        raise BadInput(f"the run {run.folder} has only one time to show: no film")
    return [frames[k] for k in np.unique(np.linspace(0, len(frames) - 1, min(most, len(frames))).astype(int))]


def frame_rate(number):
    """Frames per second, so that a film of few frames lasts and one of many flows."""
    return int(np.clip(number / 12, 4, 25))


def pictures(run, times, show="speed", colour=None, streamlines=False):
    """The frames at the times one by one, each a shot(); show: what of the fields is drawn, one of SHOWN; colour: of the bodies,
    see Look; streamlines: over the fields."""
    length, second = run.units["length"], run.units["time"]
    fields, lines, with_velocity = FieldsInTime(run), streamlines or show == "stream", bool(run.fields)
    scale, extend, levels, look = None, "neither", None, Look(run, colour)
    if lines and not with_velocity:
        raise BadInput(f"the run {run.folder} wrote no fields, of which streamlines are drawn (-fields SECONDS)")
    if with_velocity:
        sample = sorted(set(np.linspace(0, len(run.fields) - 1, min(12, len(run.fields))).astype(int)))
        known = [run.field(k)[1] for k in sample]
        scale, extend = scale_of([shown_of(values, show, run) for values in known], show)
        levels = scale_of([shown_of(values, "stream", run) for values in known], "stream")[0] if lines else None
    label, both = label_of(show, run.units), with_velocity and look.label
    figure, (axes,), bar = panels(1, run.extent, height=6.4, margins=TWO_BARS if both else MARGINS, lowest=lowest_with(label
        if with_velocity else look.label or ""))
    figure.set_dpi(DPI)
    draw_boundary(axes, run)
    frame(axes, run.extent, length, names=run.names)
    inches = figure.get_size_inches()
    heading = figure.text(0.5, axes.get_position().y1 + 0.06 / inches[1], "", ha="center", va="bottom")
    if look.label:
        look.draw_bar(figure, second_bar(figure, bar) if both else bar)
    elif not with_velocity:
        bar.remove()
    drawn, mesh_drawn, contours, bodies = None, None, None, []
    for count, t in enumerate(times):
        for artist in bodies:
            artist.remove()
        if with_velocity:
            mesh, values = fields.at(t)
            if drawn is not None and np.array_equal(mesh.triangles, mesh_drawn):
                drawn.set_array(shown_of(values, show, run))
            else:
                if drawn is not None:
                    drawn.remove()
                drawn, mesh_drawn = draw_speed(axes, mesh, shown_of(values, show, run), **scale), mesh.triangles
                figure.colorbar(drawn, cax=bar, extend=extend).set_label(label)
            if contours is not None:
                contours.remove()
            contours = draw_streamlines(axes, mesh, shown_of(values, "stream", run), levels, "#505050" if show == "vorticity"
                else "white") if lines else None
        bodies = draw_particles(axes, run, t, look)
        heading.set_text(fitting([f"{run.title}, {time_text(t, second, times[-1])}{look.words()}", f"{run.title}, "
            f"{time_text(t, second, times[-1])}", time_text(t, second, times[-1])], inches[0]))
        if count == 0:
            centre(figure, heading)
        yield shot(figure)
    plt.close(figure)


def shot(figure):
    """A figure as a (height, width, 3) array of bytes, even in both sizes."""
    if not getattr(figure, "folded", False):
        fold_powers(figure)
        contain(figure)
        figure.folded = True
    figure.canvas.draw()
    picture = np.asarray(figure.canvas.buffer_rgba())[:, :, :3]
    return np.ascontiguousarray(picture[:picture.shape[0] // 2 * 2, :picture.shape[1] // 2 * 2])


def write_mp4(path, shots, rate):
    """Write the pictures as H.264; raises ImportError or OSError where that cannot be done."""
    import imageio_ffmpeg
    writer = None
    for shot in shots:
        if writer is None:
            size = shot.shape[1], shot.shape[0]
            writer = imageio_ffmpeg.write_frames(str(path), size, fps=rate, codec="libx264", quality=None,
                                                 macro_block_size=2, pix_fmt_out="yuv420p", ffmpeg_log_level="error",
                                                 output_params=["-crf", "20", "-threads", "1"])
            writer.send(None)
        writer.send(shot)
    writer.close()


def write_gif(path, shots, rate):
    """Write the pictures as a looping gif, half as large."""
    from PIL import Image
    images = []
    for shot in shots:
        image = Image.fromarray(shot)
        images.append(image.resize((image.width // 2, image.height // 2), Image.LANCZOS).quantize(128))
    images[0].save(path, save_all=True, append_images=images[1:], duration=int(1000 / rate), loop=0, optimize=True)


def mp4_possible():
    """True if an ffmpeg with H.264 is at hand."""
    try:
        import imageio_ffmpeg
        imageio_ffmpeg.get_ffmpeg_exe()
        return True
    except (ImportError, RuntimeError, OSError):
        return False


def write_film(out, shots, rate, gif=False):
    """The shots as film.mp4, or film.gif where asked for or no mp4 can be made, in the folder `out`; returns its path."""
    as_gif = gif or not mp4_possible()
    path = Path(out) / ("film.gif" if as_gif else "film.mp4")
    part = path.with_name("film_part" + path.suffix)  # a film cut short never bears the final name
    try:
        (write_gif if as_gif else write_mp4)(part, shots, rate)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
    return own(path)


def make_film(run, out, most=300, gif=False, **look):
    """Write film.mp4 or film.gif into the folder `out`; returns its path. look: show, colour, streamlines of pictures()."""
    times = thinned(run, list(film_times(run)), most)
    return write_film(out, pictures(run, times, **look), frame_rate(len(times)), gif)
