"""State files, the program's and those made by hand: reading, writing, and the tubes in them."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import kinds, rotations
from .kinds import Kinds
from .problems import Unusable
from .units import time_text

Array = NDArray[Any]
Path = str | os.PathLike[str]

# Columns of the rows that readers here know, and what they are where a file has none
# (None: it must have them).
ROWS: dict[str, tuple[int, float | None]] = {
    "position": (3, None), "orientation": (4, None), "fibre": (1, None), "index": (1, None),
    "image": (3, 0), "group": (1, 0), "bond_broken": (1, 0), "kind": (1, 0)}
PLACES = ("state", "field", "mesh")
# Bits of the group masks: held by a grip of the tension test.
LEFT_GRIP, RIGHT_GRIP = 1 << 28, 1 << 29
BLOCK = 16384  # rows at a time; also the chunk of the datasets


def no_ids() -> Array:
    return np.zeros(0, np.int64)


def no_links() -> Array:
    return np.zeros((0, 2), np.int64)


def straight() -> Array:
    return np.zeros(3)


def lattice(box: Array, tilt: Array) -> Array:
    """Rows: the ways to the next image across x, y, z."""
    ways = np.diag(box)
    ways[[1, 2, 2], [0, 0, 1]] = tilt
    return ways


@dataclass
class State:
    """Segments, a row each, and their box."""
    rows: dict[str, Array]  # datasets of /state by name: position, orientation, velocity, ...
    lower: Array
    upper: Array
    periodic: Array = field(default_factory=lambda: np.zeros(3, bool))
    step: int = 0
    time: float = 0.0
    units: str = "nano"
    closed: Array = field(default_factory=no_ids)  # ids of the fibres that are rings
    attributes: dict[str, Any] = field(default_factory=dict)
    # Attributes of /run: by which run it was written.
    run: dict[str, Any] = field(default_factory=dict)
    kinds: Kinds = Kinds()
    values: Array | None = None  # a number for each segment, where one was asked for
    links: Array = field(default_factory=no_links)  # [L,2]: rows of both ends of each whole link
    broken_links: int = 0  # which the program counts among the broken bonds
    # Slides of the images: along x across y, along x across z, along y across z.
    tilt: Array = field(default_factory=straight)

    def __len__(self) -> int:
        return len(self.rows["position"])

    def __getitem__(self, name: str) -> Array:
        if name not in self.rows and ROWS.get(name, (1, None))[1] is not None:
            columns, default = ROWS[name]
            return np.asarray(np.full((len(self), columns)[:columns], default, int))
        return self.rows[name]

    def __contains__(self, name: str) -> bool:
        return name in self.rows

    @property
    def box(self) -> Array:
        return np.asarray(self.upper - self.lower)

    @property
    def whole(self) -> Array:
        """Positions with periodic images undone."""
        return np.asarray(self["position"] + self.images @ lattice(self.box, self.tilt))

    @property
    def images(self) -> Array:
        """The file's, or those by which each segment follows on the one before it on its fibre, as
        the program reads files without."""
        image = self["image"]
        if "image" in self or not ({"fibre", "index"} <= self.rows.keys() and self.periodic.any()):
            return image
        order = self.in_order()
        turns = self.turns(np.diff(self["position"][order], axis=0))
        turns[np.diff(self["fibre"][order]) != 0] = 0
        total = np.zeros_like(image)
        total[1:] = -np.cumsum(turns, axis=0)
        # Each fibre starts in the image of its first segment.
        first = np.unique(self["fibre"][order], return_index=True, return_inverse=True)
        image[order] = total - total[first[1]][first[2]]
        return image

    def turns(self, way: Array) -> Array:
        """Periods of the box [N,3] in ways between segments, beyond those to the nearest images."""
        turns = np.zeros(way.shape, int)
        for k in (2, 1, 0):
            if self.periodic[k]:
                turns[:, k] = np.round(way[:, k] / self.box[k])
                way = way - turns[:, k, None] * lattice(self.box, self.tilt)[k]
        return turns

    def nearest(self, way: Array) -> Array:
        """Ways between segments, to their nearest images."""
        return np.asarray(way - self.turns(way) @ lattice(self.box, self.tilt))

    @property
    def time_text(self) -> str:
        return time_text(self.time, self.units)

    @property
    def stage(self) -> int:
        """Through how many runs of the program it had gone before the one that wrote it."""
        return int(np.ravel(self.run.get("stage", 0))[0])

    @property
    def moment(self) -> tuple[int, int]:
        """What snapshots are put in order by: steps begin at 0 again in each stage."""
        return self.stage, self.step

    def radius(self, given: Sequence[float] = (), usual: float = math.nan) -> Array:
        """Of each segment [N], in the state's unit of length: one given for all or one for each
        kind, else as the run that wrote the state had it, else `usual`."""
        return np.asarray(self.kinds.thickness(given, usual)[self["kind"]])

    def in_order(self) -> Array:
        """Rows by fibre and index."""
        return np.asarray(np.lexsort((self["index"], self["fibre"])))


class StateFile:
    """A state file, open for reading; `with` closes it."""

    def __init__(self, name: Path) -> None:
        self.name = str(name)
        try:
            self.file = h5py.File(name, "r")
        except FileNotFoundError:
            raise Unusable(f"{name}: no such file") from None
        except PermissionError:
            raise Unusable(f"{name}: not permitted to read it") from None
        except OSError:
            raise Unusable(self.foreign) from None
        try:
            self.read_header()
        except Unusable:
            self.file.close()
            raise

    foreign_text = "damaged, or not a nanoweft state file"

    @property
    def foreign(self) -> str:
        return f"{self.name}: {self.foreign_text}"

    def __enter__(self) -> StateFile:
        return self

    def __exit__(self, *_: object) -> None:
        self.file.close()

    def read_header(self) -> None:
        try:
            self.group = self.file["state"]
            self.attributes = {key: as_text(value) for source in (self.file, self.group)
                               for key, value in source.attrs.items()}
            self.run = ({key: as_text(value) for key, value in self.file["run"].attrs.items()}
                        if "run" in self.file else {})
            names = self.group["kind"].attrs.get("kinds") if "kind" in self.group else None
        except (OSError, KeyError, AttributeError, RuntimeError):
            raise Unusable(self.foreign) from None
        if self.attributes.get("format") != "nanoweft-state":
            raise Unusable(f"{self.name}: not a nanoweft state file")
        if np.any(self.attributes.get("version") != 1):
            raise Unusable(f"{self.name}: version {self.attributes.get('version')} of the format; "
                           "this reads 1")
        missing = [key for key in ("lower", "upper") if key not in self.attributes]
        if missing:
            raise Unusable(f"{self.name}: no {missing[0]} in it")
        try:
            self.step, self.time = (int(self.attributes.get("step", 0)),
                                    float(self.attributes.get("time", 0)))
            self.units = str(self.attributes.get("units", "nano"))
            self.lower, self.upper = (np.array(self.attributes[key], float).reshape(3)
                                      for key in ("lower", "upper"))
            self.periodic = np.array(self.attributes.get("periodic", (0, 0, 0))).reshape(3) != 0
            self.tilt = np.array(self.attributes.get("tilt", (0, 0, 0)), float).reshape(3)
        except (TypeError, ValueError) as error:
            raise Unusable(f"{self.name}: attributes missing or wrong ({error})") from None
        try:
            self.kinds = kinds.read(names, self.run.get("fibre"))
        except Unusable as problem:
            raise Unusable(f"{self.name}: {problem}") from None
        self.check_shapes()

    def check_shapes(self) -> None:
        self.count = -1
        for key, (columns, default) in ROWS.items():
            if key not in self.group:
                if default is None and key != "orientation":
                    raise Unusable(f"{self.name}: no {key} in it")
                continue
            shape = getattr(self.group[key], "shape", None)
            if key == "position":
                self.count = shape[0] if shape else 0
                if self.count == 0:
                    raise Unusable(f"{self.name}: holds no segments")
            if shape != ((self.count,) if columns == 1 else (self.count, columns)):
                raise Unusable(f"{self.name}: {key} does not match the {self.count} segments")

    def block(self, name: str, begin: int, end: int) -> Array:
        """Some rows of one dataset; the default where the file has none."""
        columns, default = ROWS[name]
        if name not in self.group:
            if default is None:
                raise Unusable(f"{self.name}: no {name} in it")
            return np.full((end - begin, columns)[:columns], default)
        try:
            return self.rows(name, begin, end)
        except OSError:
            raise Unusable(f"{self.name}: damaged "
                           f"(segments {begin} to {end - 1} cannot be read)") from None

    def rows(self, name: str, begin: int = 0, end: int | None = None) -> Array:
        """Some rows of a dataset that the file has."""
        rows = np.asarray(self.group[name][begin:end])
        if name == "kind" and (problem := self.kinds.problem(rows, begin)):
            raise Unusable(f"{self.name}: {problem}")
        return rows

    def names(self) -> list[str]:
        """Datasets with a row for each segment."""
        return [name for name, data in self.group.items()
                if isinstance(data, h5py.Dataset) and data.shape[:1] == (self.count,)
                and name != "fibre_closed"]

    def read(self, names: Iterable[str] | None = None, values: str | None = None) -> State:
        """The state with these datasets (None: all),
        and a number for each segment from the dataset `values`."""
        there = self.names()
        try:
            rows = {name: self.rows(name) for name in there if names is None or name in names}
            closed = self.group["fibre_closed"][()] if "fibre_closed" in self.group else no_ids()
        except (OSError, RuntimeError):
            raise Unusable(self.foreign) from None
        for name in {"position", "orientation"} & rows.keys():
            rows[name] = np.asarray(rows[name], float)
        if not np.isfinite(rows["position"]).all():
            raise Unusable(f"{self.name}: some position is not finite")
        state = State(rows, self.lower, self.upper, self.periodic, self.step, self.time, self.units,
                      closed, self.attributes, self.run, self.kinds, tilt=self.tilt)
        if "link" in self.file and {"fibre", "index"} <= rows.keys():
            state.links, state.broken_links = self.links(state)
        if values:
            state.values = self.numbers(values)
        return state

    def links(self, state: State) -> tuple[Array, int]:
        """Rows of the state at both ends [L,2] of each link that is whole, and how many are not."""
        try:
            ends = self.file["link/segments"][()]
            whole = (self.file["link/broken"][()] == 0 if "broken" in self.file["link"]
                     else np.ones(len(ends), bool))
        except (OSError, KeyError, TypeError, RuntimeError):
            raise Unusable(self.foreign) from None
        if ends.shape[1:] != (2, 2) or ends.dtype.kind not in "iu" or whole.shape != ends.shape[:1]:
            raise Unusable(f"{self.name}: /link/segments must hold whole numbers [L,2,2],"
                           " /link/broken as many rows")
        places = zip(state["fibre"].tolist(), state["index"].tolist())
        row = {place: k for k, place in enumerate(places)}
        try:
            found = [row[fibre, index] for fibre, index in ends[whole].reshape(-1, 2).tolist()]
        except KeyError as lost:
            fibre, index = lost.args[0]
            raise Unusable(f"{self.name}: a link ends at fibre {fibre}, segment {index}, which is"
                           " not there") from None
        return np.array(found, np.int64).reshape(-1, 2), int((~whole).sum())

    def drawable(self) -> dict[str, h5py.Dataset]:
        """Datasets with a number or a vector for each segment."""
        groups = [self.file[place] for place in PLACES
                  if isinstance(self.file.get(place), h5py.Group)]
        found: dict[str, h5py.Dataset] = {}
        for group in groups:
            for name, data in group.items():
                if (isinstance(data, h5py.Dataset) and data.dtype.kind in "fiu"
                        and data.shape[:1] == (self.count,) and data.ndim <= 2):
                    found.setdefault(name, data)
        return found

    def numbers(self, name: str) -> Array:
        """A number for each segment: a dataset, or the lengths of its vectors."""
        there = self.drawable()
        if name not in there:
            if any(name in self.file.get(place, ()) for place in PLACES):
                raise Unusable(f"{self.name}: {name} holds no number or vector for each segment")
            raise Unusable(f"{self.name}: no dataset {name} to colour by; "
                           f"there are {', '.join(sorted(there))}")
        try:
            values = there[name][()].astype(float)
        except (OSError, RuntimeError):
            raise Unusable(self.foreign) from None
        values = np.linalg.norm(values, axis=1) if values.ndim == 2 else values
        if not np.isfinite(values).any():
            raise Unusable(f"{self.name}: {name} holds no finite number")
        return np.asarray(values)


def as_text(value: Any) -> Any:
    return value.decode(errors="replace") if isinstance(value, bytes) else value


def read(name: Path, names: Iterable[str] | None = None, values: str | None = None) -> State:
    """A state file; Unusable says what is wrong with it."""
    with StateFile(name) as file:
        return file.read(names, values)


Fibre = tuple[ArrayLike, ArrayLike]  # positions and orientations of its segments


def of_fibres(fibres: Sequence[Fibre], lower: ArrayLike, upper: ArrayLike,
              periodic: ArrayLike = (0, 0, 0), closed: bool = False) -> State:
    """A state of whole fibres, numbered from 0; `closed`: each of them is a ring."""
    count = [len(np.asarray(position)) for position, _ in fibres]
    return State({"position": np.concatenate([np.asarray(position, float)
                                              for position, _ in fibres]),
                  "orientation": np.concatenate([np.asarray(q, float) for _, q in fibres]),
                  "fibre": np.repeat(np.arange(len(fibres)), count),
                  "index": np.concatenate([np.arange(n) for n in count])},
                 np.array(lower, float), np.array(upper, float), np.array(periodic, bool),
                 closed=np.arange(len(fibres)) if closed else no_ids())


def of_kinds(state: State, names: Sequence[str], kind: ArrayLike) -> State:
    """The state with kinds of these names; `kind`: number of the kind of each fibre, by its id."""
    state.rows["kind"] = np.asarray(kind, np.int32)[state["fibre"]]
    state.kinds = Kinds(tuple(names))
    return state


def at_rest(state: State) -> State:
    """The state with fibres whose shape at rest is the one that they have."""
    first, second = find_bonds(state)
    rest = np.zeros((len(state), 3))
    rest[first] = rotations.rotation_vectors(rotations.multiply(
        state["orientation"][first] * (1, -1, -1, -1), state["orientation"][second]))
    state.rows["rest_rotation"] = rest
    return state


def write(name: Path, state: State) -> None:
    """A state file as one makes it by hand: without digest and provenance. Unusable for a state
    with links, which it would lose."""
    if len(state.links):
        raise Unusable(f"{name}: the state has links, which states.write does not write")
    with h5py.File(name, "w") as file:
        group = file.create_group("state")
        group.attrs.update(format="nanoweft-state", version=1, step=state.step, time=state.time,
                           units=state.units,
                           lower=np.asarray(state.lower, float),
                           upper=np.asarray(state.upper, float),
                           periodic=np.asarray(state.periodic, np.int32))
        if state.tilt.any():
            group.attrs["tilt"] = state.tilt
        for key, rows in state.rows.items():
            group[key] = rows
        if "kind" in state and state.kinds.names:
            group["kind"].attrs["kinds"] = ",".join(state.kinds.names)
        if len(state.closed):
            group["fibre_closed"] = state.closed


def link(name: Path, ends: ArrayLike, length: float | None = None) -> None:
    """Adds links to a state file made by hand: fibre and index of both ends, [L,2,2]. `length`: of
    all at rest; by default each is at rest as it is."""
    with h5py.File(name, "r+") as file:
        group = file.create_group("link")
        group["segments"] = np.asarray(ends, np.int64)
        if length is not None:
            group["rest_length"] = np.full(len(group["segments"]), length)


def turn_back(name: Path) -> None:
    """Reverses all velocities in a state file, which then is one made by hand."""
    state = read(name)
    for velocity in ("velocity", "angular_velocity"):
        state.rows[velocity] = -state.rows[velocity]
    write(name, state)


class Tubes(NamedTuple):
    """Rows joined by a bond, or a row with itself where a segment has lost both bonds."""
    position: Array
    first: Array
    second: Array
    torn: Array  # [2, rows]: whether the bond before, and after, broke


def find_bonds(state: State) -> tuple[Array, Array]:
    """Rows at both ends of each bond, broken ones, too: along fibres, then of each ring from its
    last segment to its first."""
    fibre, index = state["fibre"], state["index"]
    order = state.in_order()
    same = np.diff(fibre[order]) == 0
    joined = np.flatnonzero(same & (np.diff(index[order]) == 1))
    first, second = order[joined], order[joined + 1]
    starts, ends = order[np.append(True, ~same)], order[np.append(~same, True)]
    closed = np.isin(fibre[starts], state.closed)
    return np.append(first, ends[closed]), np.append(second, starts[closed])


def find_tubes(state: State) -> Tubes:
    fibre = state["fibre"]
    first, second = find_bonds(state)
    position = state.whole
    through = (np.abs(position[first] - position[second])
               > 0.5 * state.box)[:, state.periodic].any(axis=1)
    broken = state["bond_broken"][first] != 0
    torn = np.zeros((2, len(fibre)), bool)
    torn[0, second[broken]] = torn[1, first[broken]] = True

    drawn = ~(broken | through)
    first, second = first[drawn], second[drawn]
    alone = np.ones(len(fibre), bool)
    alone[first] = alone[second] = False
    rest = np.flatnonzero(alone)
    return Tubes(position, np.append(first, rest), np.append(second, rest), torn)


def half_links(state: State) -> tuple[Array, Array]:
    """Rows at which links end, and the way from there to the middle of the link, by the nearest
    image of its other end."""
    first, second = state.links.T
    way = state.nearest(state["position"][second] - state["position"][first])
    return np.append(first, second), 0.5 * np.concatenate([way, -way])


def blocks(count: int) -> Iterator[tuple[int, int]]:
    """Begins and ends of the blocks in which many rows are read."""
    for begin in range(0, count, BLOCK):
        yield begin, min(begin + BLOCK, count)
