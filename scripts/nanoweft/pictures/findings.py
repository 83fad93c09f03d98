"""The curves of an analysis, and its numbers over the snapshots, as one sheet of plots."""

from __future__ import annotations

import itertools
import math
import pathlib
from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
from numpy.typing import NDArray

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from ..analysis.survey import Row, columns_of  # noqa: E402
from ..problems import Unusable  # noqa: E402
from ..units import SECONDS, TIME, largest_unit  # noqa: E402
from .style import CYCLE, INK, TABLES  # noqa: E402

Array = NDArray[Any]
COLUMNS = 3
NAMED = 6  # snapshots at most that the legend names all
DASHES = ("-", "--", ":", "-.")  # of stages


def draw(output: str, rows: Sequence[Row]) -> None:
    """Writes a picture; Unusable where there is nothing to draw or the file cannot be written."""
    curves = list(dict.fromkeys(curve.name for row in rows for curve in row.curves
                                if curve.look != "table"))
    trends = list(dict.fromkeys(each for row in rows for each in row.trends)) * (len(rows) > 1)
    count = len(curves) + len(trends)
    if not count:
        raise Unusable("nothing to draw")
    across = min(count, COLUMNS)
    down = math.ceil(count / across)
    with plt.rc_context(TABLES):
        figure, axes = plt.subplots(down, across, figsize=(4.2 * across, 3 * down + 0.4),
                                    squeeze=False,
                                    layout="constrained")
        for panel, name in zip(axes.flat, curves):
            draw_curves(panel, name, rows)
        for panel, names in zip(axes.flat[len(curves):], trends):
            draw_trends(panel, names, rows)
        for panel in axes.flat[count:]:
            panel.set_axis_off()
        add_legend(figure, rows)
        try:
            figure.savefig(output, dpi=150)
        except (OSError, ValueError) as error:
            raise Unusable(f"cannot write {output}: {error}")
        finally:
            plt.close(figure)


def colours(count: int) -> list[Any]:
    """In the order of the snapshots."""
    if count <= NAMED:
        return list(CYCLE[:count])
    return list(plt.get_cmap("viridis")(np.linspace(0, 0.9, count)))


def title(row: Row) -> str:
    return f"{pathlib.Path(row.name).name}, {row.state.time_text}"


def add_legend(figure: Any, rows: Sequence[Row]) -> None:
    if len(rows) < 2:
        figure.suptitle(title(rows[0]), fontsize=9)
        return
    figure.get_layout_engine().set(rect=(0, 0, 1, 1 - 0.5 / figure.get_figheight()))
    shown = range(len(rows)) if len(rows) <= NAMED else sorted({0, len(rows) // 2, len(rows) - 1})
    tints = colours(len(rows))
    handles = [plt.Line2D([], [], color=tints[k]) for k in shown]
    figure.legend(handles, [title(rows[k]) for k in shown],
                  loc="upper center", ncols=min(len(handles), COLUMNS), fontsize=8)


def draw_curves(panel: Any, name: str, rows: Sequence[Row]) -> None:
    """One curve of each snapshot that has it."""
    found = [(tint, curve) for tint, row in zip(colours(len(rows)), rows) for curve in row.curves
             if curve.name == name]
    first = found[0][1]
    for k, (tint, curve) in enumerate(found):
        if curve.look == "bars":
            width = 0.8 / len(found)
            panel.bar(curve.x + (k + 0.5) * width - 0.4, curve.y, width, color=tint)
        elif curve.look == "steps":
            edges = np.append(curve.x,
                              2 * curve.x[-1] - curve.x[-2] if len(curve.x) > 1 else curve.x + 1)
            edges = edges - 0.5 * (edges[1] - edges[0])
            panel.stairs(curve.y, edges, color=tint, lw=1.3, fill=len(found) == 1,
                         alpha=0.8 if len(found) == 1 else None)
        elif curve.look == "logarithmic":
            shown = curve.y > 1e-8 * curve.y.max()
            panel.loglog(curve.x[shown], curve.y[shown], color=tint, lw=1, marker=".", ms=3)
            panel.tick_params(which="minor", labelsize=6)
        else:
            panel.plot(curve.x, curve.y, color=tint)
    panel.set(xlabel=first.labels[0], ylabel=first.labels[1])
    if first.ticks:
        panel.set_xticks(range(len(first.ticks)), first.ticks)
    if first.look != "logarithmic" and min(curve.y.min() for _, curve in found) >= 0:
        panel.set_ylim(bottom=0)


def draw_trends(panel: Any, names: tuple[str, ...], rows: Sequence[Row]) -> None:
    """Columns of one unit over time, or over the number of the snapshot where time stands still; a
    line for each stage, since time begins at 0 again in each."""
    second = SECONDS["si" if rows[0].state.units == "si" else "nano"]
    seconds = np.array([row.state.time for row in rows]) * second
    label, x = "snapshot", np.arange(1.0, len(rows) + 1)
    if np.ptp(seconds) > 0:
        unit, size = largest_unit(float(seconds.max()), TIME)
        label, x = f"time, {unit}", seconds / size
    stage = np.array([row.state.stage for row in rows])
    stages = np.unique(stage)
    units = {column.name: column.unit for column in columns_of(rows)}
    for name, tint in zip(names, [INK, *CYCLE]):
        values = np.array([row.value(name) for row in rows])
        for each, dash in zip(stages, itertools.cycle(DASHES)):
            order = np.flatnonzero(stage == each)
            order = order[np.argsort(x[order], kind="stable")]
            panel.plot(x[order], values[order], dash, marker=".", color=tint,
                       label=name + f", stage {each + 1}" * (len(stages) > 1))
    unit = units.get(names[0], "1")
    panel.set(xlabel=label, ylabel="" if unit == "1" else unit.replace("A", "Å"))
    panel.legend(loc="best", fontsize=8)
