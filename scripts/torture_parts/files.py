"""What the program's files must be: whole states, tables without holes, the same bytes."""

import hashlib
import pathlib
import re

import h5py
import numpy as np


def problem_of_state(path: pathlib.Path) -> str | None:
    """What is wrong with a state file: damaged, foreign, or not as its digest says."""
    data = path.read_bytes()
    digest = re.search(rb"[0-9a-f]{64}", data[:512])
    if not data.startswith(b"\x89HDF"):
        if not digest:
            return f"{path.name}: no digest in the user block"
        if hashlib.sha256(data[512:]).hexdigest().encode() != digest[0]:
            return f"{path.name}: the digest does not fit"
    try:
        with h5py.File(path) as file:
            if file["state"].attrs["format"] not in ("nanoweft-state", b"nanoweft-state"):
                return f"{path.name}: another format"
            bad: list[str] = []

            def look(name: str, item: h5py.Dataset | h5py.Group) -> None:
                if isinstance(item, h5py.Dataset):
                    values = item[()]
                    if values.dtype.kind == "f" and not np.isfinite(values).all():
                        bad.append(name)

            file.visititems(look)
            if bad:
                return f"{path.name}: numbers that are not finite in {', '.join(bad)}"
    except (OSError, KeyError, ValueError) as error:
        return f"{path.name}: {error}"
    return None


def step_of_state(path: pathlib.Path) -> int:
    with h5py.File(path) as file:
        return int(file["state"].attrs["step"])


def rows_of_table(path: pathlib.Path) -> tuple[list[str], list[list[float]], bool]:
    """Column names, complete rows, and whether a torn line follows."""
    lines = path.read_text(errors="replace").split("\n")
    torn = lines.pop() != ""
    lines = [line for line in lines if not line.startswith("#")]
    if not lines:
        return [], [], torn
    rows = [[float(cell) for cell in line.split(",")] for line in lines[1:]]
    return lines[0].split(","), rows, torn


def problem_of_table(path: pathlib.Path, interval: int, through: int) -> str | None:
    """A hole, a doubled row, a wrong width, or rows missing up to the step `through`."""
    try:
        names, rows, _ = rows_of_table(path)
    except ValueError as error:
        return f"{path.name}: {error}"
    if any(len(row) != len(names) for row in rows):
        return f"{path.name}: rows of other widths"
    steps = [int(row[0]) for row in rows]
    wanted = list(range(0, through + 1, interval))
    if steps[:len(wanted)] != wanted:
        missing = sorted(set(wanted) - set(steps))
        return (f"{path.name}: steps {missing[:5]} of {len(missing)} missing up to {through}"
                if missing else f"{path.name}: steps out of order")
    if any(later <= earlier for earlier, later in zip(steps, steps[1:])):
        return f"{path.name}: steps do not grow"
    if not all(np.isfinite(row).all() for row in rows):
        return f"{path.name}: numbers that are not finite"
    return None


def first_difference(a: pathlib.Path, b: pathlib.Path) -> str | None:
    """Where two files differ, or nothing; states may name other inputs."""
    if not a.exists() or not b.exists():
        return f"{a.name} is missing"
    one, other = a.read_bytes(), b.read_bytes()
    if one == other:
        return None
    if a.suffix == ".h5":
        return _difference_of_states(a, b)
    keep = [line for line in one.split(b"\n") if not line.startswith(b"# input ")]
    want = [line for line in other.split(b"\n") if not line.startswith(b"# input ")]
    if keep == want:
        return None
    for number, (left, right) in enumerate(zip(keep, want)):
        if left != right:
            return f"{a.name}: line {number + 1} differs"
    return f"{a.name}: {len(keep)} lines instead of {len(want)}"


def _difference_of_states(a: pathlib.Path, b: pathlib.Path) -> str | None:
    try:
        with h5py.File(a) as one, h5py.File(b) as other:
            left, right = _content(one), _content(other)
    except (OSError, KeyError) as error:
        return f"{a.name}: {error}"
    if left.get("run@input") == right.get("run@input"):
        names = [name for name in sorted(left.keys() | right.keys())
                 if left.get(name) != right.get(name)]
        return f"{a.name}: {', '.join(names[:5]) or 'bytes outside of the data'} differ"
    names = [name for name in sorted(left.keys() | right.keys())
             if left.get(name) != right.get(name) and name != "run@input"]
    return f"{a.name}: {', '.join(names[:5])} differ" if names else None


def _content(file: h5py.File) -> dict[str, bytes]:
    found: dict[str, bytes] = {}

    def look(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset):
            found[name] = np.asarray(item[()]).tobytes()
        for key, value in item.attrs.items():
            found[f"{name}@{key}"] = (value.encode() if isinstance(value, str)
                                      else np.asarray(value).tobytes())

    file.visititems(look)
    return found
