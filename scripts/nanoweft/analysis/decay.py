"""How fast an energy falls to its plateau."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class Decay(NamedTuple):
    """plateau + height exp(-(t - t[begin]) / constant)"""
    plateau: float
    height: float
    constant: float
    begin: int


def fit_decay(time: Array, energy: Array) -> Decay | None:
    """The exponential nearest to the energy from where half of its fall is done; None unless the
    run is long enough to tell."""
    begin = int(np.argmax(energy - energy.min() <= (energy[0] - energy.min()) / 2))
    t, e = time[begin:] - time[begin], energy[begin:]
    if len(t) < 8 or np.ptp(e) <= 1e-9 * np.abs(e).max():
        return None
    best: tuple[float, float, float, float] | None = None
    constants = np.geomspace(2 * t[1], 2 * t[-1], 400)
    for tau in constants:
        # For a given time constant the two others follow from linear least squares.
        decay = np.exp(-t / tau)
        deviation = decay - decay.mean()
        height = (deviation @ e) / (deviation @ deviation)
        plateau = e.mean() - height * decay.mean()
        misfit = np.sum((plateau + height * decay - e) ** 2)
        if height > 0 and (best is None or misfit < best[0]):
            best = misfit, plateau, height, tau
    if best is None or best[3] == constants[-1]:
        return None
    return Decay(*best[1:], begin)
