"""State files: what a picture needs of them, and the tubes in them."""

import h5py
import numpy as np

NEEDED = ("position", "fibre", "index")
OPTIONAL = ("image", "group", "bond_broken", "fibre_closed")
ROWS = NEEDED + OPTIONAL[:3]
PLACES = ("state", "field", "mesh")


class Unusable(Exception):
    """What was given cannot be drawn; the text says why."""


def as_text(value):
    return value.decode(errors="replace") if isinstance(value, bytes) else value


def read_state(name, field=None):
    """What /state holds, and under "values" the rows of the dataset `field`, if one is named."""
    try:
        with h5py.File(name, "r") as file:
            group = file["state"]
            state = {key: group[key][()] for key in NEEDED + OPTIONAL if key in group}
            for source in (file, group):
                state.update((key, as_text(value)) for key, value in source.attrs.items())
            if state.get("format") != "nanoweft-state":
                raise Unusable(f"{name}: not a nanoweft state file")
            missing = [key for key in NEEDED + ("lower", "upper") if key not in state]
            if missing:
                raise Unusable(f"{name}: no {missing[0]} in it")
            if field:
                state["values"] = read_field(file, name, field, len(state["fibre"]))
    except FileNotFoundError:
        raise Unusable(f"{name}: no such file")
    except (OSError, KeyError, AttributeError, TypeError, ValueError, RuntimeError):
        raise Unusable(f"{name}: damaged, or not a nanoweft state file")
    check(name, state)
    state["units"] = state.get("units", "nano")
    return state


def read_field(file, name, field, count):
    """A number for each segment: the dataset, or the lengths of its vectors."""
    def drawable(data):
        return (isinstance(data, h5py.Dataset) and data.dtype.kind in "fiu"
                and data.shape[:1] == (count,) and data.ndim <= 2)

    groups = [file[place] for place in PLACES if isinstance(file.get(place), h5py.Group)]
    for group in groups:
        if field in group:
            if not drawable(group[field]):
                raise Unusable(f"{name}: {field} holds no number or vector for each segment")
            values = group[field][()].astype(float)
            values = np.linalg.norm(values, axis=1) if values.ndim == 2 else values
            if count and not np.isfinite(values).any():
                raise Unusable(f"{name}: {field} holds no finite number")
            return values
    there = sorted({key for group in groups for key in group if drawable(group[key])})
    raise Unusable(f"{name}: no dataset {field} to colour by; there are {', '.join(there)}")


def check(name, state):
    count = len(state["fibre"])
    if count == 0:
        raise Unusable(f"{name}: holds no segments")
    for key in state.keys() & set(ROWS):
        if state[key].shape != ((count, 3) if key in ("position", "image") else (count,)):
            raise Unusable(f"{name}: {key} does not match the {count} segments")
    if np.size(state["lower"]) != 3 or np.size(state["upper"]) != 3:
        raise Unusable(f"{name}: lower and upper are not corners of a box")
    if not np.isfinite(state["position"]).all():
        raise Unusable(f"{name}: some position is not finite")


def find_tubes(state):
    """Where the segments are, and the tubes: rows joined by a bond, or a row with itself where a
    segment has lost both bonds. `torn` tells by row whether the bond before, and after, broke."""
    fibre, index = state["fibre"], state["index"]
    order = np.lexsort((index, fibre))
    same = np.diff(fibre[order]) == 0
    joined = np.flatnonzero(same & (np.diff(index[order]) == 1))
    first, second = order[joined], order[joined + 1]
    starts, ends = order[np.append(True, ~same)], order[np.append(~same, True)]
    closed = np.isin(fibre[starts], state.get("fibre_closed", []))
    first, second = np.append(first, ends[closed]), np.append(second, starts[closed])

    box = np.ravel(state["upper"]) - np.ravel(state["lower"])
    periodic = np.ravel(state.get("periodic", np.zeros(3))).astype(bool)
    position = state["position"] + state.get("image", 0) * box
    through = (np.abs(position[first] - position[second]) > 0.5 * box)[:, periodic].any(axis=1)
    broken = state.get("bond_broken", np.zeros(len(fibre)))[first] != 0
    torn = np.zeros((2, len(fibre)), bool)
    torn[0, second[broken]] = torn[1, first[broken]] = True

    drawn = ~(broken | through)
    first, second = first[drawn], second[drawn]
    alone = np.ones(len(fibre), bool)
    alone[first] = alone[second] = False
    alone = np.flatnonzero(alone)
    return position, np.append(first, alone), np.append(second, alone), torn


def unit_for(length, units):
    """The largest of the usual units of length that keeps the number above two."""
    ladder = {"si": [("nm", 1e-9), ("µm", 1e-6), ("mm", 1e-3), ("m", 1.0)]}.get(
        units, [("Å", 1.0), ("nm", 10.0), ("µm", 1e4), ("mm", 1e7)])
    return next((unit for unit in reversed(ladder) if length >= 2 * unit[1]), ladder[0])


def time_text(state):
    """The state's time, such as 1.25 ns."""
    time = float(state.get("time", 0)) * (1 if state["units"] == "si" else 1e-15)
    ladder = [("fs", 1e-15), ("ps", 1e-12), ("ns", 1e-9), ("µs", 1e-6), ("ms", 1e-3), ("s", 1.0)]
    name, size = next((unit for unit in reversed(ladder) if time >= unit[1]), ladder[0])
    return f"{time / size:.4g} {name}"
