"""What is looked at in snapshots, and the tables of it."""

from __future__ import annotations

import contextlib
import csv
import os
import pathlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple, TextIO

import numpy as np

from ..problems import Unusable
from ..states import State, StateFile
from .bundles import CLASSES, Fabric, named, usual_distance
from .contacts import contacts
from .findings import Column, Curve, Findings, Settings
from .loads import energy, stress
from .orientation import orientation
from .pores import pores
from .porosity import porosity
from .sample import Lacking, Sample
from .shape import crimp, curvature

NEEDED = ("position", "orientation", "fibre", "index", "image", "bond_broken", "kind",
          "rest_extension")


def bundles(sample: Sample) -> Findings:
    """As scripts/bundles counts them."""
    found = Findings(trends=("bundle_mean", "bundle_max"))
    beside = sample.settings.beside
    try:
        beside = beside or usual_distance(sample.state, sample.settings.radius)
    except Lacking as reason:
        raise Lacking(f"{sample.name}: {reason}; give --beside")
    try:
        fabric = Fabric(sample.state, beside, sample.settings.length)
    except Unusable as error:
        raise Lacking(f"{sample.name}: {error}")
    every = sample.settings.every
    seeds = np.flatnonzero(fabric.index % every == every // 2)
    if not len(seeds):
        raise Lacking(f"{sample.name}: no fibre has {every // 2 + 1} segments; lower --every")
    sizes = fabric.sizes(seeds)
    share = [100 * float(np.mean((sizes >= low) & (sizes <= (high or np.inf))))
             for low, high in CLASSES]
    found.add("bundle_mean", float(sizes.mean()), "1", "fibres in the bundle that passes a segment")
    found.add("bundle_max", float(sizes.max()), "1", "fibres in the largest bundle")
    found.add("bundle_alone", share[0] / 100, "1",
              "share of segments that run beside no other fibre")
    found.add("bundle_neighbours", float(fabric.neighbours.mean()), "1",
              "fibres side by side with a segment")
    found.curves.append(Curve("bundles", np.arange(float(len(CLASSES))), np.array(share),
                              ("fibres in the bundle", "segments, %"), "bars",
                              tuple(named(*each) for each in CLASSES)))
    return found


TOPICS: dict[str, Callable[[Sample], Findings]] = {
    "orientation": orientation, "bundles": bundles, "porosity": porosity, "contacts": contacts,
    "crimp": crimp, "curvature": curvature, "pores": pores, "stress": stress, "energy": energy}


class Row(NamedTuple):
    """Of one snapshot."""
    name: str
    state: State
    columns: list[Column]
    curves: list[Curve]
    trends: tuple[tuple[str, ...], ...]  # of each topic, columns to draw over the snapshots

    def value(self, column: str) -> float:
        return next((one.value for one in self.columns if one.name == column), np.nan)


def look(name: str, topics: Iterable[str], settings: Settings,
         missed: dict[str, str] | None) -> Row:
    """One snapshot. What a file lacks goes to `missed`, by topic, or ends it where that is None."""
    with StateFile(name) as file:
        state = file.read(NEEDED)
        sample = Sample(name, state, settings)
        try:
            sample.fields = {key: data[()] for key, data in file.drawable().items()
                             if key.endswith("_energy")}
        except (OSError, RuntimeError):
            raise Unusable(file.foreign) from None
    row = Row(name, state, [], [], ())
    for topic in topics:
        try:
            found = TOPICS[topic](sample)
        except Lacking as problem:
            if missed is None:
                raise
            missed.setdefault(topic, str(problem))
            continue
        row = row._replace(columns=row.columns + found.columns, curves=row.curves + found.curves,
                           trends=row.trends + (found.trends,))
    return row


def columns_of(rows: Sequence[Row]) -> list[Column]:
    """Of all snapshots, each once."""
    found: dict[str, Column] = {}
    for row in rows:
        for column in row.columns:
            found.setdefault(column.name, column)
    return list(found.values())


@contextlib.contextmanager
def replaced(name: str) -> Iterator[TextIO]:
    """A file that takes its place when it is complete."""
    target = pathlib.Path(name)
    temporary = target.with_name(target.name + ".tmp")
    try:
        with open(temporary, "w", newline="") as file:
            yield file
        os.replace(temporary, target)
    except OSError as error:
        raise Unusable(f"cannot write {name}: {error.strerror}") from None
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def write_table(name: str, rows: Sequence[Row]) -> None:
    """A row for each snapshot; what one does not have is nan."""
    columns, time = columns_of(rows), "time_s" if rows[0].state.units == "si" else "time_fs"
    with replaced(name) as file:
        file.writelines(f"# snapshot {k}: {row.name}\n" for k, row in enumerate(rows, 1))
        file.writelines(f"# {one.name} [{one.unit}]: {one.meaning}\n" for one in columns)
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["snapshot", "step", time, *(one.name for one in columns)])
        for k, row in enumerate(rows, 1):
            out.writerow([k, row.state.step, f"{row.state.time:.17g}",
                          *(f"{row.value(one.name):.10g}" for one in columns)])


def write_curves(name: str, rows: Sequence[Row]) -> None:
    """A row for each point of a curve."""
    meanings: dict[str, Any] = {curve.name: curve for row in rows for curve in row.curves}
    with replaced(name) as file:
        file.writelines(f"# snapshot {k}: {row.name}\n" for k, row in enumerate(rows, 1))
        for key, curve in meanings.items():
            x = ", ".join(curve.ticks) or curve.labels[0]
            file.write(f"# {key}: x {x}; y {curve.labels[1]}\n")
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["snapshot", "curve", "x", "y"])
        for k, row in enumerate(rows, 1):
            for curve in row.curves:
                out.writerows([k, curve.name, f"{x:.10g}", f"{y:.10g}"]
                              for x, y in zip(curve.x.tolist(), curve.y.tolist()))
