"""Panels on a page with labels, scale bar and what explains the colours; pages to files."""

import itertools
import os
import pathlib
import shutil
import subprocess
from typing import NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, ScalarFormatter
from PIL import Image

from .states import Unusable, unit_for


class Layout(NamedTuple):
    """Of a page, in pixels: panels of width x height in columns, a strip on the right for the
    colours, one below for the scale bar, and one above each panel for its label."""
    page: tuple
    columns: int
    rows: int
    width: int
    height: int
    font: int
    right: int
    label: int


def lay_out(size, longest, aspect, count, columns, labelled, colours):
    """`size` of the page, or None: as the panels' aspect wants it, the longer side `longest`."""
    columns = columns or next(n for n in range(1, count + 1) if n * n * aspect >= 0.6 * count or n == count)
    rows = -(-count // columns)
    font = max(9, round(max(size or (longest,)) / 72))
    words = max((len(text) for text, _ in colours.legend), default=0)
    right = round(font * max(6.2 if colours.scale else 0, 0.62 * words + 2.4 if words else 0))
    label, bottom = 2 * font if labelled else 0, round(2.2 * font)
    gap = font // 2
    around = np.array([right + gap * (columns - 1), bottom + rows * label + gap * (rows - 1)])
    if size is None:
        width = (longest - around[0]) / columns
        height = (longest - around[1]) / rows
        width = min(width, height * aspect)
        height = width / aspect
    else:
        width, height = (np.array(size) - around) / (columns, rows)
    width, height = int(width), int(height)
    if min(width, height) < 40:
        raise Unusable(f"no room for {count} panels of 40 pixels and more; choose a larger --size")
    page = size or (int(columns * width + around[0]), int(rows * height + around[1]))
    return Layout(page, columns, rows, width, height, font, right, label)


def compose(layout, panels, labels, pixel, units, colours, ink, paper):
    """The page as an array of bytes; `pixel` is a pixel's size in the state's unit of length."""
    width, height = layout.page
    font, gap = layout.font, layout.font // 2
    page = np.empty((height, width, 3), np.float32)
    page[:] = to_rgb(paper)
    figure = Figure(figsize=(width / 100, height / 100), dpi=100)
    canvas = FigureCanvasAgg(figure)
    points = 0.72 * font

    def write(x, y, text, size=1.0, **more):
        figure.text(x / width, 1 - y / height, text, size=size * points, color=more.pop("color", ink),
                    va=more.pop("va", "center"), **more)

    for n, panel in enumerate(panels):
        x = n % layout.columns * (layout.width + gap)
        y = n // layout.columns * (layout.height + layout.label + gap) + layout.label
        page[y:y + layout.height, x:x + layout.width] = panel
        if layout.label:
            write(x + 0.6 * font, y - 0.5 * layout.label, labels[n])
    figure.figimage(np.uint8(255 * page + 0.5), zorder=-1)
    scale_bar(figure, layout, pixel, units, ink, write)
    side = width - layout.right
    if colours.scale:
        cmap, norm, title = colours.scale
        axes = figure.add_axes(((side + 2.2 * font) / width, 0.3, 0.9 * font / width, 0.4))
        bar = figure.colorbar(ScalarMappable(norm, cmap), cax=axes)
        bar.outline.set_visible(False)
        bar.locator, bar.formatter = MaxNLocator(6), ScalarFormatter(useMathText=True, useOffset=False)
        bar.formatter.set_powerlimits((-2, 4))
        bar.update_ticks()
        bar.ax.yaxis.get_offset_text().set(size=0.85 * points, color=ink, x=3)
        bar.ax.tick_params(labelsize=0.85 * points, color=ink, labelcolor=ink, length=0.3 * points)
        bar.ax.yaxis.set_label_position("left")
        bar.set_label(title, size=points, color=ink)
    for k, (text, colour) in enumerate(colours.legend):
        y = (1.5 + 1.7 * k) * font
        write(side + 0.6 * font, y, "●", color=colour)
        write(side + 1.7 * font, y, text, size=0.9)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def scale_bar(figure, layout, pixel, units, ink, write):
    font, (width, height) = layout.font, layout.page
    longest = layout.width * pixel / 4
    decade = 10 ** np.floor(np.log10(longest))
    length = max(step * decade for step in (1, 2, 5) if step * decade <= longest)
    name, size = unit_for(2 * length, units)
    left, low, long = font, height - 1.1 * font, length / pixel
    figure.add_artist(Line2D([left / width, (left + long) / width], [1 - low / height] * 2,
                                 color=ink, lw=0.17 * font, solid_capstyle="butt"))
    write(left + long + 0.6 * font, low, f"{length / size:g} {name}")


def write_file(output, write):
    """Nothing is left behind, and nothing replaced, unless all of it could be written."""
    path = pathlib.Path(output)
    part = path.with_name(f".{path.stem}.part{path.suffix}")
    try:
        write(str(part))
        os.replace(part, path)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise Unusable(f"cannot write {output}: {reason}")
    finally:
        part.unlink(missing_ok=True)


def write_picture(output, page):
    write_file(output, lambda name: Image.fromarray(page).save(name, quality=92, optimize=True))


def write_movie(output, pages, rate):
    """An animated GIF, or what ffmpeg makes of an .mp4, from an iterator over pages."""
    if pathlib.Path(output).suffix.lower() == ".gif":
        write_file(output, lambda name: write_gif(name, list(pages), rate))
    else:
        if not shutil.which("ffmpeg"):
            raise Unusable(f"{output}: there is no ffmpeg to write it; a .gif needs none")
        write_file(output, lambda name: write_mp4(name, pages, rate))


def write_gif(name, pages, rate):
    # One palette for all frames, or still parts would flicker; the paper needs one colour only.
    some = np.concatenate([page.reshape(-1, 3) for page in (pages[0], pages[len(pages) // 2], pages[-1])])
    paper = pages[0][-1, -1]
    some = np.concatenate([some[(some != paper).any(axis=1)], paper[None]])
    palette = Image.fromarray(some[None]).quantize(256, method=Image.Quantize.MEDIANCUT)
    frames = [Image.fromarray(page).quantize(palette=palette, dither=Image.Dither.NONE) for page in pages]
    last = 1000 if len(frames) > 1 else 0
    frames[0].save(name, save_all=True, append_images=frames[1:], loop=0, optimize=False,
                   duration=[round(1000 / rate)] * (len(frames) - 1) + [round(1000 / rate) + last])


def write_mp4(name, pages, rate):
    first = next(pages)
    height, width = (side - side % 2 for side in first.shape[:2])  # the format has no odd sides
    command = ["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
               "-s", f"{width}x{height}", "-r", f"{rate:g}", "-i", "-", "-pix_fmt", "yuv420p", "-crf", "18", name]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        for page in itertools.chain([first], pages):
            process.stdin.write(np.ascontiguousarray(page[:height, :width]).tobytes())
        process.stdin.close()
    except BrokenPipeError:
        pass
    error = process.stderr.read().decode(errors="replace").strip()
    if process.wait() != 0:
        raise OSError(error.splitlines()[-1] if error else "ffmpeg failed")
