"""What a results folder holds: series of states, tables, pictures."""

from __future__ import annotations

import pathlib
import re
from dataclasses import dataclass, field

import numpy as np

from .. import snapshots, tables
from ..problems import Unusable
from ..states import LEFT_GRIP, RIGHT_GRIP, StateFile
from ..tables import Table

PICTURES = (".png", ".jpg", ".jpeg")


@dataclass
class Header:
    """What is known of a state without its segments."""
    file: pathlib.Path
    time: float
    step: int
    count: int
    units: str
    purpose: str
    run: dict[str, str]


@dataclass
class Series:
    """Snapshots of one name, by time."""
    name: str
    frames: list[Header]
    energy: Table | None = None
    stress: Table | None = None


@dataclass
class Folder:
    path: pathlib.Path
    series: list[Series] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    pictures: list[pathlib.Path] = field(default_factory=list)
    unusable: list[str] = field(default_factory=list)  # why files were left out

    @property
    def headers(self) -> list[Header]:
        return [frame for series in self.series for frame in series.frames]


def header(file: pathlib.Path) -> Header:
    with StateFile(file) as state:
        run = {key: str(value) for key, value in state.run.items()
               if key in ("program", "version", "options", "input", "purpose")}
        return Header(file, state.time, state.step, state.count, state.units,
                      run.get("purpose", ""), run)


def survey(path: pathlib.Path) -> Folder:
    """Looks at all files of a folder; those that cannot be read are named in `unusable`."""
    if not path.is_dir():
        raise Unusable(f"{path}: no such folder")
    folder = Folder(path)
    groups: dict[str, list[Header]] = {}
    singles: list[Header] = []
    files = sorted(path.glob("*.h5"))
    others = snapshots.left(files)
    folder.unusable += map(snapshots.named, others)
    for file in sorted(set(files).difference(*others)):
        try:
            found = header(file)
        except Unusable as problem:
            folder.unusable.append(str(problem))
            continue
        if found.purpose == "checkpoint" or "checkpoint" in file.stem:
            continue
        numbered = re.fullmatch(r"(.+)_(\d{4,})", file.stem)
        if numbered:
            groups.setdefault(numbered[1], []).append(found)
        else:
            singles.append(found)
    for name, frames in groups.items():
        folder.series.append(Series(name, sorted(frames, key=lambda f: (f.time, f.step))))
    folder.series.sort(key=lambda series: min(f.file.stat().st_mtime for f in series.frames))
    if not folder.series:
        folder.series = [Series(single.file.stem, [single]) for single in singles]
    for file in sorted(path.glob("*.csv")):
        try:
            table = tables.read(file)
        except Unusable as problem:
            folder.unusable.append(str(problem))
            continue
        if len(table) and {"time_fs", "time_s"} & set(table):
            folder.tables.append(table)
    folder.pictures = [file for file in sorted(path.iterdir()) if file.suffix.lower() in PICTURES]
    for series in folder.series:
        series.energy = belonging(series,
                                  [t for t in folder.tables if "kinetic" in t and "stretch" in t])
        if pulled(series):
            series.stress = belonging(series, [t for t in folder.tables if "stress_left_GPa" in t])
    return folder


def pulled(series: Series) -> bool:
    """Whether two grips hold the piece."""
    with StateFile(series.frames[-1].file) as state:
        group = state.read(("position", "group"))["group"]
    return bool(np.any(group & LEFT_GRIP) and np.any(group & RIGHT_GRIP))


def belonging(series: Series, candidates: list[Table]) -> Table | None:
    """The table that the run of the snapshots wrote: by provenance where both have it,
    else by name and time."""
    def likeness(table: Table) -> tuple[bool, bool, float, int]:
        options = series.frames[-1].run.get("options", "").split("\n")
        same = bool(table.options) and table.options == [line for line in options if line]
        seconds = 1e-15 if series.frames[0].units != "si" else 1.0
        times = np.array([frame.time for frame in series.frames]) * seconds
        inside = float(np.mean((times >= table.time[0] * (1 - 1e-9))
                               & (times <= table.time[-1] * (1 + 1e-9))))
        stem = pathlib.Path(table.name).stem
        return same, inside > 0, (series.name in stem) + inside, -len(stem)
    best = max(candidates, key=likeness, default=None)
    return best if best is not None and likeness(best)[1] else None
