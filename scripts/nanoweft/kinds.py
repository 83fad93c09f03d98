"""Kinds of segments: what they are called, and how thick they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .problems import Unusable

Array = NDArray[Any]

NUMBERS = 8  # of a kind in the attribute `fibre` of /run; the first of them is its radius


@dataclass(frozen=True)
class Kinds:
    """Kinds of a state, in the order of the numbers in /state/kind. A state without that dataset
    has one, which has no name."""
    names: tuple[str, ...] = ()
    radii: tuple[float, ...] = ()  # in the state's unit of length; none without a run

    def __len__(self) -> int:
        return max(1, len(self.names))

    def thickness(self, given: Sequence[float] = (), usual: float = math.nan) -> Array:
        """Radii [kinds]: one given for all or one for each kind, else the run's, else `usual`.

        Unusable where other than one or as many as there are kinds are given."""
        radii = given or self.radii or (usual,)
        if len(radii) not in (1, len(self)):
            raise Unusable(f"{len(radii)} radii given, but the kinds are {len(self)}"
                           + f" ({', '.join(self.names)})" * bool(self.names))
        return np.array(np.broadcast_to(radii, len(self)), float)

    def problem(self, kind: Array, begin: int = 0) -> str:
        """What is wrong with the kinds [rows] of segments, counted from `begin`; or nothing."""
        if kind.dtype.kind not in "iu":
            return "kind holds no whole numbers"
        wrong = np.flatnonzero((kind < 0) | (kind >= len(self)))
        if not len(wrong):
            return ""
        found = f"segment {begin + wrong[0]} is of kind {kind[wrong[0]]}, but "
        if self.names:
            return found + f"kinds names {len(self)} ({', '.join(self.names)}), from 0 on"
        return found + "the dataset kind has no attribute kinds with their names"


def read(names: Any, fibre: Any) -> Kinds:
    """Of the attributes `kinds` of /state/kind (names with commas between, or an array of them) and
    `fibre` of /run, each None where the file has none. Unusable says what is wrong with them."""
    kinds = Kinds(() if names is None else split(names))
    if fibre is None:
        return kinds
    numbers = np.ravel(fibre)
    radii = numbers[::NUMBERS]
    if numbers.dtype.kind != "f" or len(numbers) != NUMBERS * len(kinds) or not (radii > 0).all():
        raise Unusable(f"fibre of /run does not hold {NUMBERS} numbers, first a radius above 0, for"
                       f" each of {len(kinds)} kind{'s' * (len(kinds) > 1)}")
    return Kinds(kinds.names, tuple(radii.tolist()))


def split(names: Any) -> tuple[str, ...]:
    texts = [one.decode(errors="replace") if isinstance(one, bytes) else str(one)
             for one in np.ravel(names)]
    parts = tuple(part.strip() for part in ",".join(texts).split(","))
    if any(part.split() != [part] for part in parts) or len(set(parts)) < len(parts):
        raise Unusable(f"kinds is '{','.join(parts)}', not names without blanks, each another")
    return parts
