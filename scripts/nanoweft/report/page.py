"""The page: facts, pictures, plots and the 3-D view in one file."""

from __future__ import annotations

import base64
import html
import io
import json
import pathlib
import re
from collections.abc import Iterable
from typing import Any

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_hex
from PIL import Image

from ..pictures import colours, plots, style
from ..problems import Unusable
from ..tables import Table
from ..units import time_text
from . import scene
from .folder import Folder

HERE = pathlib.Path(__file__).parent
THREE = ("/usr/share/javascript/three/build/three.min.js",
         "/usr/share/javascript/three/three.min.js",
         "/usr/share/nodejs/three/build/three.min.js")
LARGEST = 30e6          # bytes of the page
PICTURE = 1.2e6         # bytes of a picture; larger ones become JPEG
PICTURES = 8e6          # of all of them
TITLES = {"energy": "Energies", "convergence": "Convergence", "stress": "Stress over strain"}


def three() -> str:
    """three.js as Debian ships it."""
    for file in map(pathlib.Path, THREE):
        if file.exists():
            return file.read_text().replace("</script", "<\\/script")
    raise Unusable("no three.js for the 3-D view; install Debian's libjs-three")


def text(value: object) -> str:
    return html.escape(str(value))


def picture(file: pathlib.Path) -> str:
    """A picture as the source of an <img>; large ones are made smaller."""
    data, kind = file.read_bytes(), "png" if file.suffix.lower() == ".png" else "jpeg"
    if len(data) > PICTURE:
        with Image.open(io.BytesIO(data)) as image:
            image = image.convert("RGB")
            image.thumbnail((1600, 1600))
            out = io.BytesIO()
            image.save(out, "JPEG", quality=86, optimize=True)
        data, kind = out.getvalue(), "jpeg"
    return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"


def thinned(table: Table, rows: int = 3000) -> Table:
    if len(table) <= rows:
        return table
    kept = np.round(np.linspace(0, len(table) - 1, rows)).astype(int)
    if "stress_left_GPa" in table:  # the plot names the strength
        kept = np.append(kept, np.argmax(table["stress_left_GPa"] + table["stress_right_GPa"]))
    kept = np.unique(kept)
    return Table(table.name, {name: column[kept] for name, column in table.columns.items()},
                 table.comments)


def plot(kind: str, table: Table) -> str:
    """A plot as SVG whose inks are the page's, so that it fits light and dark."""
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": kind + table.name}):
        figure = plots.draw(kind, [thinned(table)], [pathlib.Path(table.name).name])
        out = io.StringIO()
        figure.savefig(out, format="svg", transparent=True, metadata={"Date": None})
        plt.close(figure)
    svg = out.getvalue()
    svg = svg[svg.index("<svg"):]
    svg = re.sub(r'(<svg[^>]*?) height="[^"]*"([^>]*?) width="[^"]*"', r"\1\2", svg)
    svg = re.sub(r'(<svg[^>]*?) width="[^"]*"([^>]*?) height="[^"]*"', r"\1\2", svg)
    for fixed, own in ((style.INK, "var(--ink)"), (style.GREY, "var(--muted)"),
                       (style.GRID, "var(--line)"), (style.BLUE, "var(--blue)")):
        svg = re.sub(fixed, own, svg, flags=re.I)
    unique = re.sub(r"\W", "_", kind + pathlib.Path(table.name).stem)
    svg = re.sub(r'id="([^"]+)"', rf'id="{unique}_\1"', svg)
    svg = re.sub(r'(href="#|url\(#)', rf"\1{unique}_", svg)
    return svg


def all_plots(folder: Folder) -> Iterable[tuple[str, str]]:
    for table in folder.tables:
        for kind, (_, columns) in plots.KINDS.items():
            if len(table) > 2 and all(column in table for column in columns):
                name = pathlib.Path(table.name).name
                yield f"{TITLES[kind]} · {name}", plot(kind, table)


def facts(folder: Folder) -> dict[str, list[str]]:
    """Program and options of each different run that left files here, and the files."""
    found: dict[str, list[str]] = {}
    for header in folder.headers:
        if header.run.get("program"):
            options = [line for line in header.run.get("options", "").split("\n") if line]
            if header.run.get("input"):
                options.append(f"input {header.run['input']}")
            head = f"{header.run['program']} {header.run.get('version', '')}".strip()
            found.setdefault("\n".join([head, *options]), []).append(header.file.name)
    for table in folder.tables:
        if table.program:
            rest = [line for line in table.comments[1:] if line.startswith(("-", "input "))]
            found.setdefault("\n".join([table.program, *rest]),
                             []).append(pathlib.Path(table.name).name)
    return found


def files_text(files: list[str]) -> str:
    shown = files if len(files) <= 6 else [*files[:3], "…", files[-1]]
    return ", ".join(shown) + ("" if len(files) <= 6 else f" ({len(files)} files)")


def facts_html(folder: Folder) -> str:
    found = facts(folder)
    if not found:
        return ('<p class="muted">The files here do not say by which options they were made '
                "(they are of an older version, or made by hand).</p>")
    parts = []
    for key, files in found.items():
        head, *lines = key.split("\n")
        rows = []
        for line in lines:
            name, _, value = line.partition(" ")
            rows.append(f"<tr><td><code>{text(name)}</code></td>"
                        f"<td><code>{text(value)}</code></td></tr>")
        table = (f"<table>{''.join(rows)}</table>" if rows else
                 '<p class="muted">All options at their defaults.</p>')
        parts.append(f'<article class="card"><h3>{text(head)}</h3>'
                     f'<p class="muted">{text(files_text(files))}</p>{table}</article>')
    return f'<div class="facts">{"".join(parts)}</div>'


def summary(folder: Folder, data: list[dict[str, Any]]) -> list[str]:
    """Short facts under the title."""
    words: list[str] = []
    for one in data:
        fibres = len(one["runs"])
        if not words:
            words = [f"{one['total']:,} segments", f"{fibres:,} fibres"]
            if len(one["kinds"]) > 1:
                words.append(f"{len(one['kinds'])} kinds: {', '.join(one['kinds'])}")
    times = [(header.time, header.units) for header in folder.headers]
    if times:
        words.append("to " + time_text(*max(times)))
    snapshots = len(folder.headers)
    words.append(f"{snapshots} snapshot{'s' if snapshots != 1 else ''}")
    return words


def colour_maps() -> dict[str, Any]:
    """Maps for a light and a dark ground:
    fibres, signed numbers, numbers of one sign, groups, broken."""
    def steps(cmap: Any) -> list[str]:
        return [to_hex(cmap(x)) for x in np.linspace(0, 1, 33)]
    return {name: {"fibres": steps(p.fibres), "diverging": steps(p.diverging),
                   "sequential": steps(p.sequential), "kinds": p.kinds}
            for name, p in (("light", colours.WHITE), ("dark", colours.BLACK))} | {
        "groups": colours.GROUPS, "whole": colours.WHOLE, "hurt": colours.TORN}


def write(folder: Folder, output: pathlib.Path, radii: tuple[float, ...] = (),
          largest: float = LARGEST) -> None:
    """Makes the page; radii: for all fibres or for each kind, where the files' own are not wanted.
    Unusable where there is nothing to show."""
    if not (folder.series or folder.tables or folder.pictures):
        raise Unusable(f"{folder.path}: no state, table or picture of a run")
    script = three() if folder.series else ""
    pictures, left_out = chosen_pictures(folder)
    drawn = [f'<figure class="card"><h3>{text(title)}</h3>{svg}</figure>' for title,
             svg in all_plots(folder)]
    used = len(script) + sum(map(len, pictures)) + sum(len(svg.encode()) for svg in drawn)
    budget = max(1e5, 0.9 * largest - used) / max(1, len(folder.series))
    data = [scene.series_data(series, budget, radii) for series in folder.series]
    notes = ([f"The 3-D view of {one['name']} shows {one['note']}, so that this file stays small."
              for one in data if one["note"]]
             + left_out + [f"Left out: {why}." for why in folder.unusable])
    payload = json.dumps({"series": data, "maps": colour_maps()},
                         separators=(",", ":")).replace("</", "<\\/")
    name = folder.path.resolve().name
    values = {
        "title": text(name), "style": (HERE / "page.css").read_text(),
        "summary": "".join(f"<li>{text(word)}</li>" for word in summary(folder, data)),
        "viewer": (HERE / "viewer.html").read_text() if data else "",
        "facts": facts_html(folder), "plots": section("Plots", "plots", drawn),
        "pictures": section("Pictures", "pictures", pictures),
        "notes": "".join(f"<p>{text(note)}</p>" for note in notes),
        "three": f"/* three.js, MIT licence, Copyright 2010 three.js authors */\n{script}",
        "data": payload, "script": (HERE / "page.js").read_text()}
    page = re.sub(r"\{\{(\w+)\}\}", lambda match: values[match[1]],
                  (HERE / "page.html").read_text())
    write_page(output, page)


MARK = "<!doctype html>"


def write_page(output: pathlib.Path, page: str) -> None:
    """Replaces an earlier page, and nothing else."""
    try:
        if output.exists() and not output.is_char_device():
            with output.open("rb") as file:
                begin = file.read(len(MARK))
            if begin.lower() != MARK.encode() and begin:
                raise Unusable(f"{output}: is there and no page; give another name or remove it")
        output.write_text(page)
    except OSError as error:
        raise Unusable(f"cannot write {output}: {error.strerror}") from None


def section(title: str, kind: str, parts: list[str]) -> str:
    return (f'<section><h2>{title}</h2><div class="{kind}">{"".join(parts)}</div></section>'
            if parts else "")


def chosen_pictures(folder: Folder) -> tuple[list[str], list[str]]:
    """Figures of the folder's pictures, and what to say of those that would be too much."""
    # What plots draw stands in the page already.
    plotted = {pathlib.Path(table.name).stem for table in folder.tables}
    figures, size, left = [], 0, []
    for file in folder.pictures:
        if file.stem in plotted:
            continue
        source = picture(file)
        if size + len(source) > PICTURES:
            left.append(f"{file.name} is left out, so that this file stays small.")
            continue
        size += len(source)
        figures.append('<figure class="card">'
                       f'<img src="{source}" alt="{text(file.name)}" loading="lazy">'
                       f"<figcaption>{text(file.name)}</figcaption></figure>")
    return figures, left
