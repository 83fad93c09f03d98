"""Snapshots for the 3-D view: few enough, and in few enough bytes."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import states
from ..problems import Unusable
from ..states import State, StateFile
from ..units import SECONDS, length_unit, time_text
from .folder import Header, Series

Array = NDArray[Any]
FEWEST = 12         # snapshots that are left before segments are thinned
MOST_SEGMENTS = 150_000  # more tubes no browser turns smoothly
SKIPPED = {"fibre", "index", "image", "group", "bond_broken", "position", "orientation", "points",
           "lines"}
WANTED = ("strain", "stretch_energy", "shear_energy", "bending_energy", "torsion_energy",
          "pair_energy", "velocity")
RADIUS = {"nano": 6.78, "si": 6.78e-10}  # of a (10,10) tube, where files do not tell theirs


@dataclass
class Thinning:
    """Which snapshots are shown, and every how many segments of a fibre."""
    frames: list[Header]
    stride: int
    note: str


def thin(series: Series, budget: float) -> Thinning:
    """As many snapshots and segments as fit into `budget` bytes of base64."""
    count = max(frame.count for frame in series.frames)
    with StateFile(series.frames[-1].file) as state:
        fields = sum(name in state.drawable() for name in WANTED)
    a_segment = (3 * 2 + 1 + fields) * 4 / 3
    stride = 1
    while count / stride > MOST_SEGMENTS or FEWEST * count / stride * a_segment > budget:
        stride += 1
        if stride == 64:
            break
    most = max(1, int(budget / (count / stride * a_segment)))
    frames = series.frames
    if len(frames) > most:
        chosen = np.unique(np.round(np.linspace(0, len(frames) - 1, most)).astype(int))
        frames = [frames[k] for k in chosen]
    notes = []
    if len(frames) < len(series.frames):
        notes.append(f"{len(frames)} of {len(series.frames)} snapshots")
    if stride > 1:
        notes.append(f"every {stride}. segment of a fibre")
    return Thinning(frames, stride, " and ".join(notes))


def kept_rows(state: State, stride: int) -> Array:
    """Rows by fibre and index: every stride-th of a fibre, and its last one."""
    order = state.in_order()
    if stride == 1:
        return order
    index, fibre = state["index"][order], state["fibre"][order]
    last = np.append(fibre[1:] != fibre[:-1], True)
    return np.asarray(order[(index % stride == 0) | last])


def fibre_runs(state: State, rows: Array) -> tuple[list[int], list[int]]:
    """Number of kept rows of each fibre, and whether it is a ring."""
    ids, count = np.unique(state["fibre"][rows], return_counts=True)
    return count.tolist(), np.isin(ids, state.closed).astype(int).tolist()


def torn_after(state: State, rows: Array) -> Array:
    """For each kept row, whether a bond broke between it and the next kept one of its fibre."""
    order = state.in_order()
    broken = np.concatenate([[0], np.cumsum(state["bond_broken"][order] != 0)])
    place = np.empty(len(order), int)
    place[order] = np.arange(len(order))
    begin = place[rows]
    fibre = state["fibre"][rows]
    end = np.append(begin[1:], begin[-1] + 1)
    # A fibre's last row stands for the bond that closes a ring.
    last = np.append(fibre[1:] != fibre[:-1], True)
    end[last] = begin[last] + 1
    return np.asarray(broken[end] - broken[begin] > 0)


def encoded(values: Array) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()


def quantised(values: Array, low: float, high: float) -> Array:
    share = (np.nan_to_num(values, nan=low) - low) / ((high - low) or 1.0)
    return np.asarray(np.round(254 * np.clip(share, 0, 1)) + 1, np.uint8)


def limits(columns: list[Array]) -> tuple[float, float]:
    """Of the colours: without the few extreme numbers that would wash out all others, even about
    zero where both signs occur."""
    values = np.concatenate([column[np.isfinite(column)] for column in columns])
    if not len(values):
        return 0.0, 1.0
    low, high = (float(x) for x in np.percentile(values, [0.5, 99.5]))
    if low < 0 < high and min(-low, high) > 0.02 * max(-low, high):
        low, high = -max(-low, high), max(-low, high)
    if high <= low:
        low, high = float(values.min()), float(values.max())
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def series_data(series: Series, budget: float, radii: tuple[float, ...]) -> dict[str, Any]:
    """What the page's script needs to draw a series."""
    chosen = thin(series, budget)
    wanted = ("position", "fibre", "index", "image", "group", "bond_broken", "kind")
    first = states.read(chosen.frames[0].file, wanted)
    rows = kept_rows(first, chosen.stride)
    positions: list[Array] = []
    torn: list[Array] = []
    broken: list[int] = []
    boxes: list[list[list[float]]] = []
    columns: dict[str, list[Array]] = {}
    for frame in chosen.frames:
        with StateFile(frame.file) as file:
            state = file.read(wanted)
            if len(state) != len(first):
                raise Unusable(f"{frame.file}: other fibres than in {chosen.frames[0].file}")
            positions.append(state.whole[rows].astype(np.float32))
            torn.append(torn_after(state, rows))
            boxes.append([state.lower.tolist(), *states.lattice(state.box, state.tilt).tolist()])
            broken.append(int((state["bond_broken"] != 0).sum()) + state.broken_links)
            for name in sorted(set(file.drawable()) & set(WANTED) - SKIPPED):
                columns.setdefault(name, []).append(file.numbers(name)[rows].astype(np.float32))
    low = np.min([x.min(axis=0) for x in positions], axis=0).astype(float)
    high = np.max([x.max(axis=0) for x in positions], axis=0).astype(float)
    span = np.maximum(high - low, 1e-9 * max(1.0, float(np.abs(high).max())))
    fields = [describe(name, c, first.units) for name, c in columns.items()
              if len(c) == len(chosen.frames)]
    runs, closed = fibre_runs(first, rows)
    masks, group = np.unique(first["group"][rows], return_inverse=True)
    unit, size = length_unit(float(span.max()), first.units)
    several = len(first.kinds) > 1
    return {
        "name": series.name, "count": len(rows), "total": len(first), "runs": runs,
        "closed": closed,
        "low": low.tolist(), "span": span.tolist(), "lengthUnit": [unit, size],
        "kinds": list(first.kinds.names), "radii": radii_of(first, radii),
        "kind": encoded(first["kind"][rows].astype(np.uint8)) if several else "",
        "periodic": first.periodic.astype(int).tolist(),
        "groups": [int(mask) for mask in masks], "group": encoded(group.astype(np.uint8)),
        "frames": [frame_data(chosen.frames[k], positions[k], torn[k], broken[k], low, span)
                   | {"box": boxes[k]}  # its lower corner, and the ways along its three edges
                   for k in range(len(chosen.frames))],
        "fields": fields, "note": chosen.note, "curve": curve(series, first.units)}


def radii_of(state: State, given: tuple[float, ...]) -> list[float]:
    """Of the kinds, in the state's unit of length."""
    try:
        radii = state.kinds.thickness(given, RADIUS.get(state.units, RADIUS["nano"]))
    except Unusable as problem:
        raise Unusable(f"--radius: {problem}") from None
    return [float(radius) for radius in radii]


def frame_data(frame: Header, position: Array, torn: Array, broken: int, low: Array,
               span: Array) -> dict[str, Any]:
    share = np.round((position - low) / span * 65535).astype(np.uint16)
    return {"time": time_text(frame.time, frame.units), "step": frame.step, "file": frame.file.name,
            "seconds": frame.time * SECONDS[frame.units if frame.units == "si" else "nano"],
            "position": encoded(share), "torn": np.flatnonzero(torn).tolist(),
            "broken": broken}


def describe(name: str, columns: list[Array], units: str) -> dict[str, Any]:
    factor, title = ((100.0, "strain of the bonds, %") if name == "strain" else
                     (1.0, name.replace("_", " ")))
    if name.endswith("energy"):
        title += ", J" if units == "si" else ", eV"
    if name == "velocity":
        title = "speed, m/s" if units == "si" else "speed, Å/fs"
    scaled = [factor * column for column in columns]
    low, high = limits(scaled)
    return {"name": name, "title": title, "low": low, "high": high,
            "values": [encoded(quantised(column, low, high)) for column in scaled]}


def curve(series: Series, units: str) -> dict[str, Any] | None:
    """What stands beside the fabric: stress over strain, else the elastic energy over time."""
    if series.stress is not None:
        t = series.stress
        mean = 0.5 * (t["stress_left_GPa"] + t["stress_right_GPa"])
        return points(t.time, 100 * t["strain"], mean, t["broken_bonds"],
                      ("stress over strain", "strain, %", "stress, GPa", "broken bonds"))
    if series.energy is not None:
        t = series.energy
        ps, unit = 1e12 * t.time, "J" if units == "si" else "eV"
        return points(t.time, ps, t.elastic, None,
                      ("elastic energy", "time, ps", f"energy, {unit}", ""))
    return None


def points(time: Array, x: Array, y: Array, second: Array | None,
           titles: tuple[str, str, str, str]) -> dict[str, Any]:
    rows = np.unique(np.round(np.linspace(0, len(x) - 1, min(len(x), 1500))).astype(int))

    def short(values: Array, digits: int = 6) -> list[float]:
        return [float(f"{value:.{digits}g}") for value in values[rows]]
    return {"time": short(time, 17), "x": short(x), "y": short(y),
            "second": None if second is None else short(second),
            "titles": titles}
