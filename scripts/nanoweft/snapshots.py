"""Series of snapshots, NAME_<step>.h5, and what another run has left among them."""

from __future__ import annotations

import html
import pathlib
import re
import sys
from collections.abc import Iterable

from .problems import Unusable
from .states import Path, StateFile

Origin = tuple[str, ...]


def origin(file: pathlib.Path) -> Origin:
    """By which run it was written; nothing where it does not say, or cannot be read."""
    try:
        with StateFile(file) as state:
            found = tuple(str(state.run.get(key, "")) for key in ("program", "options", "input"))
    except Unusable:
        return ()
    return found if found[0] else ()


def newest(files: Iterable[pathlib.Path], index: pathlib.Path) -> pathlib.Path:
    """The last one that the index lists, else by its date, which copies may have lost."""
    try:
        listed = re.findall(r'<Grid Name="([^"]*\.h5)">', index.read_text(errors="replace"))
    except OSError:
        listed = []
    there = {file.name: file for file in files}
    known = [there[name] for name in map(html.unescape, listed) if name in there]
    return known[-1] if known else max(there.values(),
                                       key=lambda file: (file.stat().st_mtime_ns, file.name))


def left(files: Iterable[Path]) -> list[list[pathlib.Path]]:
    """Of each series, the snapshots of another run than the newest one: -overwrite replaces those
    of the same steps alone. What lies before all of the newest run's is the part that a restart
    with other options has gone on from, and belongs to it."""
    groups: dict[pathlib.Path, dict[pathlib.Path, tuple[int, Origin]]] = {}
    for file in map(pathlib.Path, files):
        numbered = re.fullmatch(r"(.+)_(\d{10})", file.stem)
        if numbered and (run := origin(file)):
            groups.setdefault(file.with_name(numbered[1]), {})[file] = int(numbered[2]), run
    found = []
    for name, group in groups.items():
        own = group[newest(group, name.with_name(name.name + ".xdmf"))][1]
        first = min(step for step, run in group.values() if run == own)
        others = [file for file, (step, run) in group.items() if run != own and step > first]
        if others:
            found.append(sorted(others))
    return found


def named(files: list[pathlib.Path]) -> str:
    """What is said of some that `left` has found."""
    if len(files) == 1:
        return f"{files[0]}: a snapshot of another run than those beside it"
    return f"{files[0]} to {files[-1].name}: {len(files)} snapshots of another run than those" \
           " beside them"


def warn(files: Iterable[Path]) -> None:
    """A line for each series in which two runs are mixed."""
    for others in left(files):
        print(f"{pathlib.Path(sys.argv[0]).stem}: warning: {named(others)}", file=sys.stderr)


def of_run(folder: pathlib.Path, name: str) -> list[pathlib.Path]:
    """Those of one run, in order of steps; a line says what is left out."""
    files = sorted(folder.glob(f"{name}_[0-9]*.h5"))
    others = left(files)
    for some in others:
        print(f"left out: {named(some)}", file=sys.stderr)
    return [file for file in files if not any(file in some for some in others)]
