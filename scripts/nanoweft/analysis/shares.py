"""How much of the stress of a tension test each kind of fibre carries."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kinds import NUMBERS
from ..problems import Unusable
from ..states import LEFT_GRIP, RIGHT_GRIP, State, find_tubes
from ..units import GPA

Array = NDArray[Any]

LENGTH, STIFFNESS = 1, 4  # places of T and B1 among the numbers of a kind in /run


class Pull:
    """What a snapshot says of its tension test."""

    def __init__(self, name: str, state: State) -> None:
        run = state.run
        if not {"tension", "tension_axis", "tension_thickness", "tension_strain",
                "fibre"} <= set(run):
            raise Unusable(f"{name}: not a snapshot of a tension test")
        self.strain = float(run["tension_strain"][-1])
        self.axis = int(run["tension_axis"][0])
        self.area = float(run["tension"][2] * run["tension_thickness"][0])
        along = state.whole[:, self.axis]
        held = [(state["group"] & bit) != 0 for bit in (LEFT_GRIP, RIGHT_GRIP)]
        if not (held[0].any() and held[1].any()):
            raise Unusable(f"{name}: no segments held by two grips (bits 28 and 29 of group)")
        self.left, self.right = float(along[held[0]].max()), float(along[held[1]].min())


def stress_by_kind(pull: Pull, state: State) -> Array:
    """Stress [kinds] along the pull, GPa, by the axial forces B1 (r - T - rest extension) of the
    bonds: their sum over a cross-section, averaged over all between the grips, over the area."""
    numbers = np.reshape(state.run["fibre"], (-1, NUMBERS))
    tubes = find_tubes(state)
    begin, end = tubes.position[tubes.first], tubes.position[tubes.second]
    apart = end - begin
    length = np.linalg.norm(apart, axis=1)
    length[length == 0] = np.inf  # a segment without bonds
    kind = state["kind"][tubes.first]
    rest = numbers[kind, LENGTH]
    if "rest_extension" in state:
        rest = rest + state["rest_extension"][tubes.first]
    force = np.where(np.isinf(length), 0, numbers[kind, STIFFNESS] * (length - rest))
    # A bond takes part in the cross-sections that it passes.
    inside = np.clip([begin[:, pull.axis], end[:, pull.axis]], pull.left, pull.right)
    passed = np.abs(inside[1] - inside[0]) / (pull.right - pull.left)
    along = force * np.abs(apart[:, pull.axis]) / length * passed
    unit = GPA if state.units == "nano" else 1e9
    return np.bincount(kind, along, len(state.kinds)) / pull.area / unit
