"""How often a closed tube winds: the energy of a ring over its number of windings.

A tube of length L wound n times bends to the radius L/(2 pi n) and gains the adhesion of n strands
side by side (Cohen and Mahadevan, PNAS 100, 12141):

    E(n) = EJ L/2 (2 pi n/L)^2 + P(n) L/n

P(n) is the energy per length of n parallel tubes, packed most densely: a hexagon that grows around
its first strand."""

from __future__ import annotations

import itertools
import pathlib

import numpy as np

from .. import runs
from ..problems import RunFailed
from ..runs import Printed
from ..verification import tubes
from ..verification.folded import TUBE, T
from .self_folding import REACH

OPTIONS = runs.ROOT / "runs" / "windings" / "run.opts"
POINTS = 13  # on a segment, by which the energy of parallel tubes is summed to round-off
# Places of strands on a hexagonal lattice, in its two directions.
PLACES = ((0, 0), (1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1), (1, 1), (2, -1))


def packed(strands: int) -> float:
    """Energy per length of parallel tubes side by side, eV/A."""
    places = np.array([(a + b / 2, b * np.sqrt(3) / 2) for a, b in PLACES[:strands]])
    apart = [float(np.hypot(*(p - q))) for p, q in itertools.combinations(places, 2)]

    def energy(spacing: float) -> float:
        return sum(float(tubes.energy(spacing * d, 0, POINTS, "smooth")) for d in apart)
    return float(tubes.best(energy, low=16.0)[1]) if apart else 0.0


def closed_form(segments: int, windings: int) -> float:
    """Energy of a ring, eV."""
    length = segments * T
    bending = TUBE.EJ * length / 2 * (2 * np.pi * windings / length)**2
    return float(bending + packed(windings) * length / windings)


def relaxed(folder: pathlib.Path, segments: int, windings: int) -> float:
    """Energy of a ring at rest, eV; leaves its state in ring.h5."""
    done = runs.run(["-options_file", str(OPTIONS), "-ring_segments", str(segments),
                     "-ring_windings", str(windings), "-state_output", f"{folder}/ring.h5",
                     "-overwrite"])
    if done.returncode or "converged" not in done.stdout:
        raise RunFailed(f"{windings} windings: {done.stderr.strip() or done.stdout.strip()}")
    end = Printed(done.stdout)
    return end.elastic + end.energy("pair")


def over_reach(segments: int) -> float:
    """Length of a tube over l = sqrt(EI/gamma)."""
    return segments * T / REACH
