"""Runs of the program, and what they print."""

from __future__ import annotations

import functools
import os
import pathlib
import re
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Where this package is installed, the program lies beside share/.
PROGRAM = pathlib.Path(os.environ.get("NANOWEFT_PROGRAM") or (
    ROOT / "build/bin/nanoweft" if (ROOT / "CMakeLists.txt").exists()
    else ROOT.parents[1] / "bin/nanoweft")).absolute()


@functools.lru_cache(maxsize=1)
def _settings() -> tuple[tuple[str, str], ...]:
    """The variables that scripts/environment leaves, as all scripts use them."""
    lines = subprocess.run(["bash", "-c", ". scripts/environment && env -0"], cwd=ROOT, check=True,
                           capture_output=True, text=True).stdout.split("\0")
    return tuple((name, value) for name, _,
                 value in (line.partition("=") for line in lines if "=" in line))


def environment(threads: int = 1, **more: str) -> dict[str, str]:
    """Of a run with so many threads a rank."""
    return {**dict(_settings()), "OMP_NUM_THREADS": str(threads), **more}


@dataclass
class Launch:
    """How a command is started: alone (ranks None) or by mpirun, on so many threads a rank."""
    ranks: int | None = None
    threads: int = 1
    mpirun: Sequence[str] = ()  # more words for mpirun
    variables: dict[str, str] | None = None
    folder: str | os.PathLike[str] = ROOT  # in which it runs

    def __call__(self,
                 command: Sequence[str | os.PathLike[str]]) -> subprocess.CompletedProcess[str]:
        """Runs it; what it printed is text, its status the caller's to judge."""
        words: list[str | os.PathLike[str]] = list(command)
        if self.ranks is not None:
            words = ["mpirun", "--quiet", *self.mpirun, "-n", str(self.ranks), *words]
        return subprocess.run(words, cwd=self.folder, capture_output=True, text=True,
                              env=environment(self.threads, **(self.variables or {})))


def run(words: Sequence[str], launch: Launch = Launch()) -> subprocess.CompletedProcess[str]:
    """The program with these options, quiet between start and end.
    It replaces what another run left."""
    return launch([PROGRAM, *words, "-progress_interval", "0", "-overwrite"])


class Number:
    """The first that the pattern finds in what a run printed; not a number where it finds none."""

    def __init__(self, pattern: str) -> None:
        self.pattern = pattern

    def __get__(self, printed: Printed, _: type[Printed]) -> float:
        return printed.number(self.pattern)


class Printed:
    """The numbers in what one run printed."""

    drift = Number(r"drifted by ([-+.\de]+)")
    segments = Number(r"(\d+) segments, box")
    steps = Number(r"steps (\d+), simulated")
    rebuilds = Number(r"(\d+) list rebuilds")
    segment_steps = Number(r"speed: ([-+.\de]+) segment-steps")  # a second
    pairs = Number(r"segment-steps/s, ([-+.\de]+) pairs")  # a second
    memory = Number(r"memory (\d+) MB")  # of the rank that took most, MB of 1048576 bytes

    def __init__(self, text: str) -> None:
        self.text = text

    def number(self, pattern: str) -> float:
        found = re.search(pattern, self.text, re.M)
        return float(found.group(1)) if found else float("nan")

    def energy(self, name: str) -> float:
        return self.number(rf"energies .*\b{name} ([-+.\de]+)")

    @property
    def elastic(self) -> float:
        return sum(self.energy(part) for part in ("stretch", "shear", "bending", "torsion"))

    @property
    def wall(self) -> float:
        return self.steps * self.segments / self.segment_steps

    @property
    def resolved(self) -> float:
        """Pairs resolved in the whole run."""
        return self.pairs * self.wall

    @property
    def limits(self) -> tuple[float, ...]:
        """Stable steps: now, of a free chain, of fibres pressed together."""
        found = re.search(r"stable below (\S+) now, (\S+) for a free chain, about (\S+) for",
                          self.text)
        return tuple(float(x) for x in found.groups()) if found else (float("nan"),) * 3

    @property
    def events(self) -> dict[str, tuple[int, float]]:
        """The solver's own log events: name -> (count, seconds)."""
        return {name: (int(count), float(seconds)) for name, count, seconds in
                re.findall(r"^(Nw\w+)\s+(\d+) [\d.]+ ([\d.e+-]+)", self.text, re.M)}

    @property
    def partition(self) -> dict[str, Any] | None:
        """Kind, imbalance of the work, ghosts a segment and cut bonds; None on one rank."""
        found = re.search(r"partition: (\w+),.*?imbalance of work ([\d.]+), "
                          r"([\d.e+-]+) ghosts a segment, (\d+) bonds", self.text)
        return (dict(zip(("kind", "imbalance", "ghosts", "bonds"), found.groups()))
                if found else None)
