"""A closed form or a fit as a line, and on it what was measured."""

from __future__ import annotations

from typing import Any, NamedTuple

import matplotlib
import numpy as np
from numpy.typing import ArrayLike

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from .style import CYCLE, TABLES  # noqa: E402


class Curve(NamedTuple):
    """x and y of a line and of the dots on it; empty: none."""
    label: str
    line: tuple[ArrayLike, ArrayLike]
    dots: tuple[ArrayLike, ArrayLike]
    kind: str = "closed form"  # of the line


def draw(file: str, axes: tuple[str, str], curves: list[Curve], **look: Any) -> None:
    """Writes a picture; `axes`: what stands at x and at y, `look`: more for matplotlib's axes."""
    with plt.rc_context(TABLES):
        figure, panel = plt.subplots(figsize=(6, 3.6), layout="constrained")
        for curve, colour in zip(curves, CYCLE):
            if np.size(curve.line[0]):
                panel.plot(*curve.line, color=colour, label=f"{curve.label}, {curve.kind}")
            if np.size(curve.dots[0]):
                panel.plot(*curve.dots, "o", color=colour, markersize=4,
                           label=f"{curve.label}, measured")
        panel.set(xlabel=axes[0], ylabel=axes[1], **look)
        panel.legend(ncols=2 if len(curves) > 2 else 1)
        figure.savefig(file)
        plt.close(figure)
