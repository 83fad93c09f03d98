"""What the scripts share that scripts/run calls at the end of a scene (runs/*/after)."""

from __future__ import annotations

import os
import pathlib
import re
import subprocess
import sys
from collections.abc import Mapping
from types import TracebackType
from typing import Any

from . import options
from .problems import RunFailed, Unusable
from .runs import ROOT
from .tables import Table


def results() -> pathlib.Path:
    """The results folder, their argument. From here on problems are told in one line, as by
    commands."""
    sys.excepthook = tell
    return pathlib.Path(sys.argv[1])


def tell(kind: type[BaseException], problem: BaseException, trace: TracebackType | None) -> None:
    if isinstance(problem, subprocess.CalledProcessError):
        print(f"after: {pathlib.Path(problem.cmd[0]).name} failed", file=sys.stderr)
    elif isinstance(problem, (Unusable, RunFailed, OSError)):
        print(f"after: {problem}", file=sys.stderr)
    else:
        sys.__excepthook__(kind, problem, trace)


def render(*words: str | os.PathLike[str]) -> None:
    """scripts/render with these words."""
    subprocess.run([ROOT / "scripts/render", *words], check=True)


def need(enough: object, what: str) -> None:
    """Ends the script where the run has not come so far (options behind -- may shorten it)."""
    if not enough:
        raise Unusable(f"the run is too short for {what}")


def need_rest(energy: Table) -> None:
    """Ends the script where the motion is not a thousandth of what the fibres hold."""
    need(energy.motion[-1] < 1e-3 * energy.elastic[-1], "rest, so for the closed form")


def numbers(run: Mapping[str, Any], option: str, usual: str) -> list[float]:
    """The value of an option in a state's run; `usual`: its default, which is not recorded."""
    given = options.parse(str(run.get("options", "")))
    return [float(number) for number in str(given.get(option, usual)).split(",")]


def number(run: Mapping[str, Any], option: str, usual: float = 0) -> float:
    return numbers(run, option, str(usual))[0]


# Behind --, they change no closed form: at most how near and far a run comes, and what it writes.
HARMLESS = {"overwrite", "progress_interval", "monitor_interval", "snapshot_interval", "threads",
            "checkpoint_file", "checkpoint_interval", "ts_max_steps", "ts_max_time", "ts_dt",
            "damping_local", "damping_viscous", "wall_time"}


def changed() -> list[str]:
    """Options behind -- that the scene's option files do not have so: scripts/run hands them on."""
    return [word for word in sys.argv[2:]
            if re.match(r"-+[A-Za-z]", word) and word.lstrip("-") not in HARMLESS]


def as_filed(what: str) -> bool:
    """Does the scene run with the values of its option files? If not, a line says that `what` is
    theirs."""
    if changed():
        print(f"{what} for the values of the option files, without {' '.join(changed())}")
    return not changed()
