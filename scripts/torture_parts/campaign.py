"""Draws trials for a while, two at a time, and tells what came of them."""

import pathlib
import sys
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

from .damage import damage_trial, flip_trial, table_trial
from .kills import kill_trial, signal_trial
from .layouts import layout_trial
from .limits import limit_trial
from .option_sets import option_trial
from .trial import ReferenceFailed, Setting, Trial


@dataclass
class Part:
    """A kind of trial, and its share of the time."""
    attempt: Callable[[Trial], None]
    share: float
    goal: dict[str, int]  # counts of a full campaign
    next: int = 0
    seconds: float = 0.0


PARTS: dict[str, Part] = {
    "kills": Part(kill_trial, 3, {"kills": 300}),
    "signals": Part(signal_trial, 2, {"signals": 100}),
    "flips": Part(flip_trial, 3, {"flips": 2000}),
    "damage": Part(damage_trial, 1, {"other damage": 500}),
    "tables": Part(table_trial, 1, {"tables": 300}),
    "options": Part(option_trial, 2, {"option sets": 1000}),
    "limits": Part(limit_trial, 1, {"limits": 300}),
    "bytes": Part(layout_trial, 3, {"comparisons": 200}),
}


@dataclass
class Campaign:
    """Workers take the part that is furthest behind its share, until all are done."""
    setting: Setting
    parts: dict[str, Part]
    failed: pathlib.Path  # folder for what went wrong
    deadline: float | None = None  # time.monotonic()
    last: int | None = None  # trials of each part
    full: bool = False
    counts: Counter[str] = field(default_factory=Counter)
    failures: list[str] = field(default_factory=list)
    lock: threading.Lock = field(default_factory=threading.Lock)

    def _wants(self, part: Part) -> bool:
        if self.full:
            return any(self.counts[name] < count for name, count in part.goal.items())
        return self.last is None or part.next < self.last

    def _draw(self) -> tuple[str, int] | None:
        with self.lock:
            if self.deadline and time.monotonic() > self.deadline:
                return None
            open_parts = [name for name, part in self.parts.items() if self._wants(part)]
            if not open_parts:
                return None
            name = min(open_parts, key=lambda n: self.parts[n].seconds / self.parts[n].share)
            part = self.parts[name]
            part.seconds += 0.01  # so that the other worker does not draw the same part at once
            part.next += 1
            return name, part.next - 1

    def _attempt(self, name: str, number: int) -> None:
        trial = Trial(self.setting, name, number)
        start = time.monotonic()
        try:
            self.parts[name].attempt(trial)
        except ReferenceFailed as error:
            trial.fail(f"reference {error}")
        except Exception:
            trial.note(traceback.format_exc())
            trial.fail("the trial itself: " + traceback.format_exc().strip().splitlines()[-1])
        with self.lock:
            self.parts[name].seconds += time.monotonic() - start
            self.counts += trial.counts
            self.counts[f"trials of {name}"] += 1
            if trial.failures:
                line = f"{name} {number}: {trial.failures[0]}"
                self.failures.append(line)
                try:
                    line += f" ({trial.keep(self.failed)})"
                except OSError as error:
                    line += f" (its folder is lost: {error})"
                self.failures[-1] = line
                print(line, flush=True)
        trial.remove()

    def _work(self) -> None:
        try:
            while drawn := self._draw():
                self._attempt(*drawn)
        except Exception:
            with self.lock:
                self.failures.append("a worker: " + traceback.format_exc())
                print(self.failures[-1], file=sys.stderr, flush=True)

    def run(self, workers: int) -> bool:
        """Whether nothing went wrong."""
        threads = [threading.Thread(target=self._work, daemon=True) for _ in range(workers)]
        for thread in threads:
            thread.start()
        try:
            for thread in threads:
                thread.join()
        except KeyboardInterrupt:
            print("stopped", file=sys.stderr)
            return False
        return not self.failures

    def table(self) -> str:
        names = [n for part in self.parts.values() for n in part.goal]
        names += sorted(set(self.counts) - set(names))
        rows = [(name, self.counts[name]) for name in names]
        rows.append(("failures", len(self.failures)))
        return "\n".join(f"{name:24s} {count:7d}" for name, count in rows)
