"""Panels on a page with labels, scale bar and what explains the colours; pages to files."""

from __future__ import annotations

import itertools
import os
import pathlib
import shutil
import subprocess
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, ScalarFormatter
from numpy.typing import NDArray
from PIL import Image

from ..problems import Unusable
from ..units import length_unit
from .colours import Colours

Array = NDArray[Any]
Size = tuple[int, int]


class Shape(NamedTuple):
    """What a page should look like."""
    size: Size | None   # of the page, or as the panels' aspect wants it
    longest: int        # side then
    aspect: float       # of a panel
    columns: int | None
    labelled: bool


class Look(NamedTuple):
    """Of a page: a pixel in the state's unit of length, the units, colours of writing
    and ground."""
    pixel: float
    units: str
    ink: str
    paper: str


class Layout(NamedTuple):
    """Of a page, in pixels: panels of width x height in columns, a strip on the right for the
    colours, one below for the scale bar, and one above each panel for its label."""
    page: Size
    columns: int
    rows: int
    width: int
    height: int
    font: int
    right: int
    label: int


def lay_out(shape: Shape, count: int, colours: Colours) -> Layout:
    """Places for `count` panels."""
    size, longest, aspect, columns, labelled = shape
    columns = columns or next(n for n in range(1, count + 1)
                              if n * n * aspect >= 0.6 * count or n == count)
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


def compose(layout: Layout, panels: Iterator[Array], labels: Sequence[str], look: Look,
            colours: Colours) -> Array:
    """The page as an array of bytes."""
    width, height = layout.page
    font, gap = layout.font, layout.font // 2
    page = np.empty((height, width, 3), np.float32)
    page[:] = to_rgb(look.paper)
    figure = Figure(figsize=(width / 100, height / 100), dpi=100)
    canvas = FigureCanvasAgg(figure)
    points = 0.72 * font

    def write(x: float, y: float, text: str, size: float = 1.0, **more: Any) -> None:
        figure.text(x / width, 1 - y / height, text, size=size * points,
                    color=more.pop("color", look.ink),
                    va=more.pop("va", "center"), **more)

    for n, panel in enumerate(panels):
        x = n % layout.columns * (layout.width + gap)
        y = n // layout.columns * (layout.height + layout.label + gap) + layout.label
        page[y:y + layout.height, x:x + layout.width] = panel
        if layout.label:
            write(x + 0.6 * font, y - 0.5 * layout.label, labels[n])
    figure.figimage(np.uint8(255 * page + 0.5), zorder=-1)
    scale_bar(figure, layout, look, write)
    side = width - layout.right
    if colours.scale:
        colour_bar(figure, layout, look.ink, colours.scale)
    for k, (text, colour) in enumerate(colours.legend):
        down = (1.5 + 1.7 * k) * font
        write(side + 0.6 * font, down, "●", color=colour)
        write(side + 1.7 * font, down, text, size=0.9)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def colour_bar(figure: Figure, layout: Layout, ink: str,
               scale: tuple[Colormap, Normalize, str]) -> None:
    width, font, points = layout.page[0], layout.font, 0.72 * layout.font
    side = width - layout.right
    cmap, norm, title = scale
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


def scale_bar(figure: Figure, layout: Layout, look: Look, write: Callable[..., None]) -> None:
    pixel = look.pixel
    font, (width, height) = layout.font, layout.page
    longest = layout.width * pixel / 4
    decade = 10 ** np.floor(np.log10(longest))
    length = max(step * decade for step in (1, 2, 5) if step * decade <= longest)
    name, size = length_unit(2 * length, look.units)
    left, low, long = font, height - 1.1 * font, length / pixel
    figure.add_artist(Line2D([left / width, (left + long) / width], [1 - low / height] * 2,
                             color=look.ink, lw=0.17 * font, solid_capstyle="butt"))
    write(left + long + 0.6 * font, low, f"{length / size:g} {name}")


def write_file(output: str, write: Callable[[str], None]) -> None:
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


def write_picture(output: str, page: Array) -> None:
    def save(name: str) -> None:
        Image.fromarray(page).save(name, quality=92, optimize=True)
    write_file(output, save)


def write_movie(output: str, pages: Iterator[Array], rate: float) -> None:
    """An animated GIF, or what ffmpeg makes of an .mp4, from an iterator over pages."""
    if pathlib.Path(output).suffix.lower() == ".gif":
        write_file(output, lambda name: write_gif(name, list(pages), rate))
    else:
        if not shutil.which("ffmpeg"):
            raise Unusable(f"{output}: there is no ffmpeg to write it; a .gif needs none")
        write_file(output, lambda name: write_mp4(name, pages, rate))


def write_gif(name: str, pages: list[Array], rate: float) -> None:
    # One palette for all frames, or still parts would flicker; the paper needs one colour only.
    some = np.concatenate([page.reshape(-1, 3)
                           for page in (pages[0], pages[len(pages) // 2], pages[-1])])
    paper = pages[0][-1, -1]
    some = np.concatenate([some[(some != paper).any(axis=1)], paper[None]])
    palette = Image.fromarray(some[None]).quantize(256, method=Image.Quantize.MEDIANCUT)
    frames = [Image.fromarray(page).quantize(palette=palette, dither=Image.Dither.NONE)
              for page in pages]
    last = 1000 if len(frames) > 1 else 0
    frames[0].save(name, save_all=True, append_images=frames[1:], loop=0, optimize=False,
                   duration=[round(1000 / rate)] * (len(frames) - 1) + [round(1000 / rate) + last])


def write_mp4(name: str, pages: Iterator[Array], rate: float) -> None:
    first = next(pages)
    height, width = (side - side % 2 for side in first.shape[:2])  # the format has no odd sides
    command = ["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
               "-s", f"{width}x{height}", "-r", f"{rate:g}", "-i", "-", "-pix_fmt", "yuv420p",
               "-crf", "18", name]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdin and process.stderr
    try:
        for page in itertools.chain([first], pages):
            process.stdin.write(np.ascontiguousarray(page[:height, :width]).tobytes())
        process.stdin.close()
    except BrokenPipeError:
        pass
    error = process.stderr.read().decode(errors="replace").strip()
    if process.wait() != 0:
        raise OSError(error.splitlines()[-1] if error else "ffmpeg failed")
