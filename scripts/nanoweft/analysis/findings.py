"""What an analysis of one snapshot gives: numbers, one to a column of the table, and curves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


@dataclass(frozen=True)
class Settings:
    """What the user chooses; lengths in the snapshots' unit, None for what follows from them."""
    axis: int = 2  # through thickness
    bins: int = 50  # of profiles and histograms
    region: dict[int, tuple[float, float]] = field(default_factory=dict)  # limits by axis
    radius: tuple[float, ...] = ()  # of all kinds or of each
    length: float | None = None  # of a segment
    gap: float | None = None  # between surfaces in contact
    beside: float | None = None  # between axes of fibres side by side
    every: int = 5  # bundles: cross-sections at every so many segments
    cells: int = 100_000  # of a grid of pores


class Column(NamedTuple):
    """A number of a snapshot: its name in the table, its unit (1: none) and what it means."""
    name: str
    value: float
    unit: str
    meaning: str


class Curve(NamedTuple):
    """What a plot shows. `look`: line, steps, logarithmic, bars, or table, which is not drawn."""
    name: str
    x: Array
    y: Array
    labels: tuple[str, str]  # of both axes
    look: str = "line"
    ticks: tuple[str, ...] = ()  # names of the bars


@dataclass
class Findings:
    columns: list[Column] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    trends: tuple[str, ...] = ()  # columns to draw over the snapshots

    def add(self, name: str, value: float, unit: str, meaning: str) -> None:
        self.columns.append(Column(name, float(value), unit, meaning))

    def histogram(self, name: str, values: Array, bins: int, label: str) -> None:
        """A curve of shares, %, of finite values; none where there are no values."""
        values = values[np.isfinite(values)]
        if not len(values):
            return
        low, high = values.min(), values.max()
        if (values == np.round(values)).all() and high - low < 4 * bins:
            edges = np.arange(low - 0.5, high + 1)
        else:
            wide = max(high - low, 1e-3 * abs(high), 1e-300)
            edges = np.linspace(low, low + wide, bins + 1)
        share = 100 * np.histogram(values, edges)[0] / len(values)
        self.curves.append(Curve(name, 0.5 * (edges[1:] + edges[:-1]), share, (label, "fibres, %"),
                                 "steps"))
