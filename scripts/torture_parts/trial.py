"""One trial of the campaign: its folder, its random numbers, what it ran, and what went wrong."""

import pathlib
import random
import shutil
import threading
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

from .processes import Command, Outcome, Running, environment

TIMEOUT = 240.0  # seconds; a run that takes longer hangs


@dataclass
class Setting:
    """What all trials of a campaign share."""
    binary: str
    seed: int
    folder: pathlib.Path  # of the work; on a fast file system
    base: dict[str, str] = field(default_factory=environment)
    kinds: list[str] | None = None  # of scenes that the program offers
    references: dict[str, "Kept"] = field(default_factory=dict)
    lock: threading.Lock = field(default_factory=threading.Lock)

    def kept(self, key: str, make: Callable[["Trial"], None]) -> pathlib.Path:
        """A folder with results that several trials compare with; made once."""
        with self.lock:
            kept = self.references.setdefault(key, Kept(self.folder / "references" / key))
        with kept.lock:
            if not kept.made:
                trial = Trial(self, "references", 0, key)
                make(trial)
                kept.made, kept.failures = True, trial.failures
                shutil.rmtree(trial.prints, ignore_errors=True)
        if kept.failures:
            raise ReferenceFailed(f"{key}: {kept.failures[0]}")
        return kept.folder


@dataclass
class Kept:
    """A reference folder, and whether it is there yet."""
    folder: pathlib.Path
    made: bool = False
    failures: list[str] = field(default_factory=list)
    lock: threading.Lock = field(default_factory=threading.Lock)


class ReferenceFailed(Exception):
    """The undisturbed run that a trial compares with did not end well."""


class Trial:
    """A folder of its own; `random` depends on the campaign's seed, the part and the number."""

    def __init__(self, setting: Setting, part: str, number: int, name: str | None = None) -> None:
        self.setting, self.part, self.number = setting, part, number
        self.random = random.Random(f"{setting.seed}/{part}/{name or number}")
        self.folder = setting.folder / part / (name or str(number))
        self.prints = setting.folder / "prints" / part / (name or str(number))
        self.folder.mkdir(parents=True, exist_ok=True)
        self.story: list[str] = []
        self.failures: list[str] = []
        self.counts: Counter[str] = Counter()
        self._runs = 0

    def start(self, command: Command) -> Running:
        self._runs += 1
        prints = self.prints / str(self._runs)
        self.story.append(command.shell(self.setting.binary,
                                        f"prints/{self._runs}/stdin.txt"))
        return Running(self.setting.binary, command, self.folder, prints, self.setting.base)

    def run(self, command: Command, timeout: float = TIMEOUT) -> Outcome:
        return self.start(command).wait(timeout)

    def expect(self, outcome: Outcome, *allowed: int) -> bool:
        """Notes a failure unless the run ended with one of these statuses, as it should."""
        complaint = outcome.complaint(*allowed)
        if complaint:
            self.fail(complaint)
        return complaint is None

    def note(self, text: str) -> None:
        """A step between runs, for who reads the story."""
        self.story += [f"# {line}" for line in text.splitlines()]

    def fail(self, text: str) -> None:
        self.failures.append(text)

    def remove(self) -> None:
        for folder in (self.folder, self.prints):
            shutil.rmtree(folder, ignore_errors=True)

    def keep(self, where: pathlib.Path) -> pathlib.Path:
        """Copies the folder and its story there for a person."""
        target = where / f"{self.part}-{self.number}"
        shutil.rmtree(target, ignore_errors=True)
        shutil.copytree(self.folder, target, symlinks=True, ignore=_special)
        if self.prints.exists():
            shutil.copytree(self.prints, target / "prints", ignore=shutil.ignore_patterns("mpi"))
        repeat = (f"scripts/torture --seed {self.setting.seed} --only {self.part} "
                  f"--first {self.number} --trials 1")
        lines = ["#!/usr/bin/env bash", *(f"# failure: {text}" for text in self.failures),
                 f"# The whole trial again: {repeat}",
                 "# By hand, in an empty folder or one with the files that the comments name:",
                 *self.story]
        (target / "reproduce.sh").write_text("\n".join(lines) + "\n")
        return target


def _special(folder: str, names: list[str]) -> list[str]:
    """Fifos and devices, which cannot be copied."""
    return [name for name in names
            if not (path := pathlib.Path(folder) / name).is_symlink()
            and not path.is_file() and not path.is_dir()]
