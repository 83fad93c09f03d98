"""Closed forms of beam theory: springs, ladders, kinks; the (10,10) tube's rigidities."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .units import AMU, GPA

Array = NDArray[Any]


class Tube:
    """The (10,10) tube of the paper's Table 1; T, E and G may differ."""

    def __init__(self, young: float = 1029.0, shear: float = 459.0, length: float = 13.56) -> None:
        rf, h = 6.78, 3.35
        section = 2 * math.pi * h * rf
        second = math.pi * h * rf * (rf**2 + h**2 / 4)
        self.radius, self.T = rf, length
        self.ES, self.EJ = young * GPA * section, young * GPA * second
        self.GJp = shear * GPA * 2 * second
        self.m = 2649 * AMU * length / 13.56
        self.I = self.m * rf**2
        self.rho = self.m / length
        self.B1, self.B2, self.B4 = self.ES / length, 12 * self.EJ / length, self.GJp / length
        self.B3 = -2 * self.EJ / length - self.GJp / (2 * length)

    @classmethod
    def of(cls, run: Mapping[str, Any]) -> Tube:
        """The fibre (of the first kind) that a state's run had."""
        tube = cls()
        (tube.radius, tube.T, tube.m, tube.I,
         tube.B1, tube.B2, tube.B3, tube.B4) = np.ravel(run["fibre"])[:8].tolist()
        tube.ES, tube.GJp = tube.B1 * tube.T, tube.B4 * tube.T
        tube.EJ, tube.rho = -(tube.B3 + tube.B4 / 2) * tube.T / 2, tube.m / tube.T
        return tube


TUBE = Tube()


@dataclass(frozen=True)
class Spring:
    """A tube coiled around z: radius and pitch/(2 pi) at rest, A, and its turns."""
    radius: float = 100.0
    slope: float = 6.4
    turns: int = 5

    @property
    def wire(self) -> float:
        """Its length, A."""
        return 2 * math.pi * self.turns * math.hypot(self.radius, self.slope)

    @property
    def height(self) -> float:
        return 2 * math.pi * self.turns * self.slope

    @property
    def curvature(self) -> float:
        return self.radius / (self.radius**2 + self.slope**2)

    @property
    def twist(self) -> float:
        return self.slope / (self.radius**2 + self.slope**2)

    def compliance(self, tube: Tube = TUBE) -> float:
        """Extension over force, A^2/eV, of a little pull."""
        angle = math.atan(self.slope / self.radius)
        return self.turns * 2 * math.pi * self.radius**3 / math.cos(angle) * (
            math.cos(angle)**2 / tube.GJp + math.sin(angle)**2 / tube.EJ)

    def pull(self, height: ArrayLike, tube: Tube = TUBE) -> Array:
        """Force, eV/A, at a height however large, if all turns stay and the wire keeps its length:
        the slope of its energy wire/2 (EJ (curvature - rest)^2 + GJp (twist - rest)^2)."""
        turning, rest = 2 * math.pi * self.turns / self.wire, math.atan(self.slope / self.radius)
        angle = np.arcsin(np.asarray(height) / self.wire)
        return np.asarray(turning**2 * (
            tube.GJp * (np.sin(angle) - math.sin(rest))
            - tube.EJ * (np.cos(angle) - math.cos(rest)) * np.tan(angle)))


@dataclass(frozen=True)
class Ladder:
    """Two equal beams clamped at x = 0, tied by rungs that are turned with them; bent by a force
    at their tips, eV/A. A rung turned by theta whose ends slip by s holds
    rung/2 (theta - s/apart)^2."""
    length: float
    apart: float
    rung: float
    force: float

    def shear_lag(self, per_length: float, tube: Tube = TUBE) -> float:
        """Deflection at the tip with so many rungs a length, as if they were everywhere:
        N'' = a^2 N - slip d M/(2 EJ), N'(0) = N(L) = 0, N the force in the upper beam."""
        slip, length, apart = self.rung * per_length / self.apart**2, self.length, self.apart
        a2 = slip * (2 / tube.ES + apart**2 / (2 * tube.EJ))
        a, share = math.sqrt(a2), slip * apart / (2 * tube.EJ * a2)
        normal = share * self.force / a * (math.tanh(a * length) / a2 - length / a)
        return (self.force * (1 - share * apart) * length**3 / 3 - apart * normal) / (2 * tube.EJ)

    def deflection(self, places: ArrayLike, tube: Tube = TUBE) -> float:
        """At the tip with rungs at these places: each passes a force from one beam to the other,
        rung/apart (theta - s/apart)."""
        x, apart = np.asarray(places, float), self.apart
        area = self.length * x - x**2 / 2  # of the moment of a unit force, up to x
        passed = np.linalg.solve(
            np.eye(len(x)) * apart / self.rung
            + np.minimum.outer(x, x) * (apart / (2 * tube.EJ) + 2 / (tube.ES * apart)),
            self.force * area / (2 * tube.EJ))
        return float((self.force * self.length**3 / 3 - apart * passed @ area) / (2 * tube.EJ))


@dataclass(frozen=True)
class Kink:
    """A tube that kinks at a curvature, 1/A; its stiffness beyond, over that of the tube."""
    curvature: float = 1 / 275
    residual: float = 0.0

    def moment(self, angle: ArrayLike, tube: Tube = TUBE) -> Array:
        """Of a bond bent by so many radians to an arc, eV; model.md 3 and 12."""
        half = 0.5 * np.asarray(angle)
        theta, critical = 2 * np.sin(half), 2 * math.sin(0.5 * self.curvature * tube.T)
        width, over = 0.1 * critical, np.maximum(theta - critical, 0)
        less = np.where(over < width, over**2 / width, 2 * over - width)
        bending = tube.EJ / tube.T * (theta - 0.5 * (1 - self.residual) * less) * np.cos(half)
        return np.asarray(bending + tube.B2 / 2 * (1 - np.cos(half)) * np.sin(half))
