"""The length from which a tube has less energy folded upon itself than straight.

With l = sqrt(EI/gamma), gamma the adhesion per length of two tubes: a loop that is a circle gives
4 pi l (Appl. Phys. Lett. 90, 073107), the elastica 12.11 l, both for tubes of no thickness."""

from __future__ import annotations

import math
import pathlib

from .. import runs, states, tables
from ..problems import RunFailed
from ..verification import folded
from ..verification.folded import T
from ..verification.folded import W as GAMMA

OPTIONS = runs.ROOT / "runs" / "self_folding" / "run.opts"
REACH = math.sqrt(folded.TUBE.EJ / GAMMA)
CIRCLE, ELASTICA = 4 * math.pi, 12.11
PARTS = ("stretch", "shear", "bending", "torsion", "pair")


def start(file: states.Path, segments: int) -> None:
    """Writes a folded tube, its loop the elastica, its arms at the distance of two long tubes."""
    x, q = folded.racket_start(segments, reach=REACH)
    states.write(file, states.of_fibres([(x, q)], x.min(axis=0) - 200, x.max(axis=0) + 200))


def relaxed(folder: pathlib.Path, segments: int) -> float:
    """Energy of a folded tube at rest, eV; that of the straight one is nought."""
    start(folder / "other.h5", segments)
    done = runs.run(["-options_file", str(OPTIONS), "-scene_file", str(folder / "other.h5"),
                     "-energy_monitor", f"ascii:{folder}/other.csv",
                     "-state_output", str(folder / "rest.h5")])
    if done.returncode or "converged" not in done.stdout:
        raise RunFailed(f"{segments} segments: {done.stderr.strip() or done.stdout.strip()}")
    table = tables.read(folder / "other.csv")
    return float(sum(table[part][-1] for part in PARTS))


def thick(segments: int = 300, cells: int = 300) -> float:
    """Critical length over l of a planar inextensible curve with the tubes' own adhesion, at their
    distance and over its range."""
    energy = folded.curve(segments * T / 2, cells, REACH)[0] + folded.missing_end()
    return float(2 * (energy + GAMMA * segments * T / 2) / (GAMMA * REACH))
