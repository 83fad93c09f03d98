"""Runs of the solver, and what they print and write."""

import functools
import itertools
import os
import pathlib
import re
import subprocess
import threading
from concurrent.futures import Future, ThreadPoolExecutor

import h5py
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
BINARY = ROOT / "build" / "bin" / "nanoweft"


class RunFailed(Exception):
    """The solver ended with an error; the text is its own."""


def environment():
    lines = subprocess.run(["bash", "-c", f". {ROOT}/scripts/environment; env -0"], check=True,
                           capture_output=True, text=True).stdout.split("\0")
    found = dict(line.split("=", 1) for line in lines if "=" in line)
    found["OMP_NUM_THREADS"] = "1"
    return found


def read_options(file):
    """An options file as a dictionary."""
    options = {}
    for line in pathlib.Path(file).read_text().splitlines():
        words = line.split("#")[0].split()
        if words:
            options[words[0].lstrip("-")] = words[1] if len(words) > 1 else None
    return options


def read_state(file):
    """Datasets of a state, positions unwrapped; the file goes away."""
    with h5py.File(file) as f:
        g = f["state"]
        state = {name: g[name][:] for name in g if isinstance(g[name], h5py.Dataset)}
        state["position"] += state["image"] * (g.attrs["upper"] - g.attrs["lower"])
    pathlib.Path(file).unlink()
    return state


def read_table(file):
    """A table of the program's, by column."""
    with open(file) as lines:
        # genfromtxt would take names from a comment.
        return np.genfromtxt((line for line in lines if not line.startswith("#")), delimiter=",", names=True)


def kept(method):
    """Each result is computed once, by whichever thread asks first."""
    results, lock = {}, threading.Lock()

    @functools.wraps(method)
    def once(self, options, *more, **named):
        key = (tuple(sorted((k, str(v)) for k, v in options.items())), more, tuple(named.items()))
        with lock:
            first = key not in results
            future = results.setdefault(key, Future())
        if first:
            try:
                future.set_result(method(self, options, *more, **named))
            except BaseException as error:
                future.set_exception(error)
        return future.result()
    return once


class Printed:
    """The numbers in what one run printed."""

    def __init__(self, text):
        self.text = text

    def number(self, pattern):
        found = re.search(pattern, self.text)
        return float(found.group(1)) if found else float("nan")

    def energy(self, name):
        return self.number(rf"energies .*\b{name} ([-+.\de]+)")

    @property
    def elastic(self):
        return sum(self.energy(part) for part in ("stretch", "shear", "bending", "torsion"))

    @property
    def drift(self):
        return self.number(r"drifted by ([-+.\de]+)")

    @property
    def segments(self):
        return self.number(r"(\d+) segments, box")

    @property
    def steps(self):
        return self.number(r"steps (\d+), simulated")

    @property
    def segment_steps(self):
        """Segment-steps a second."""
        return self.number(r"speed: ([-+.\de]+) segment-steps")

    @property
    def wall(self):
        return self.steps * self.segments / self.segment_steps

    @property
    def resolved(self):
        """Pairs resolved in the whole run."""
        return self.number(r"segment-steps/s, ([-+.\de]+) pairs") * self.wall

    @property
    def limits(self):
        """Stable steps: now, of a free chain, of fibres pressed together."""
        found = re.search(r"stable below (\S+) now, (\S+) for a free chain, about (\S+) for", self.text)
        return tuple(float(x) for x in found.groups())

    @property
    def events(self):
        """The solver's own log events: name -> (count, seconds)."""
        return {name: (int(count), float(seconds)) for name, count, seconds in
                re.findall(r"^(Nw\w+)\s+(\d+) [\d.]+ ([\d.e+-]+)", self.text, re.M)}


class Program:
    """One rank and one thread at a time; `workers` of them side by side where time is not measured."""

    def __init__(self, folder, workers):
        self.folder = pathlib.Path(folder).resolve()
        self.folder.mkdir(parents=True, exist_ok=True)
        self.workers = workers
        self.environment = environment()
        self.count = itertools.count()

    def run(self, options, *more):
        """An option with the value None stands alone; with False it is left out."""
        words = ["-progress_interval", "0"]
        for name, value in options.items():
            if value is False:
                continue
            words += [f"-{name}"] + ([] if value is None else [str(value)])
        done = subprocess.run([BINARY, *words, *more], env=self.environment, cwd=ROOT,
                              capture_output=True, text=True)
        if done.returncode:
            raise RunFailed(f"nanoweft {' '.join(words)}: {done.stderr.strip()[-400:]}")
        return Printed(done.stdout)

    @kept
    def final(self, options, forces=False):
        """The final state (forces and torques too if asked for), and what was printed."""
        file = self.folder / f"final{next(self.count)}.h5"
        more = {"state_forces": None} if forces else {}
        printed = self.run(dict(options, state_output=file, **more))
        return read_state(file), printed

    def table(self, options):
        """The energy table, what was printed, the final state."""
        file = self.folder / f"energy{next(self.count)}.csv"
        state, printed = self.final(dict(options, energy_monitor=f"ascii:{file}"))
        rows = read_table(file)
        file.unlink()
        return rows, printed, state

    def each(self, work, items):
        """`work` for every item, side by side, results in order."""
        with ThreadPoolExecutor(self.workers) as pool:
            return list(pool.map(work, items))
