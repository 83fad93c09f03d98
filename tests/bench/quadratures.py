#!/usr/bin/python3
"""Ways to sum a pair law over segments: errors of forces, and how many evaluations they take.

    tests/bench/quadratures.py        the table of quadratures.md, a minute

Written without the program: the law is that of scripts/nanoweft/speed_error/independent.py, forces
are those on single segments, the reference is 15 x 15 points on each pair of segments.
"""
from __future__ import annotations

import pathlib
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from nanoweft import generators  # noqa: E402
from nanoweft.speed_error import independent  # noqa: E402

T = generators.LENGTH
SWITCH, CUTOFF, FROM = 3 * T, 4 * T, 2 * T
Array = np.ndarray
Slope = Callable[[Array], Array]


def energy(r: Array) -> Array:
    return independent.law(r, "smooth", SWITCH, CUTOFF)


GRID = np.linspace(6.0, CUTOFF + 1, 200001)
SLOPE = np.gradient(energy(GRID), GRID)


def slope(r: Array) -> Array:
    """u'(r)."""
    return np.interp(r, GRID, SLOPE)


def far(r: Array) -> Array:
    """u' of the far part: the law beyond FROM, a spring within."""
    return np.where(r > FROM, slope(r), r / FROM * slope(np.array(FROM)))


def near(r: Array) -> Array:
    return slope(r) - far(r)


@dataclass
class Scene:
    name: str
    x: Array
    e: Array
    fibre: Array
    own: Array  # the segments whose forces are compared

    def others(self, i: int, reach: float) -> Array:
        close = np.linalg.norm(self.x - self.x[i], axis=1) < reach
        return np.nonzero(close & (self.fibre != self.fibre[i]))[0]


@dataclass
class Found:
    force: Array
    pairs: float  # a segment, each pair counted once
    evaluations: float


def product(n: int) -> tuple[Array, Array]:
    """Places on both segments, in lengths of a segment: n x n points."""
    place = (np.arange(n) - 0.5 * (n - 1)) / n
    s, t = np.meshgrid(place, place, indexing="ij")
    return s.ravel(), t.ravel()


def lattice(n: int, step: int) -> tuple[Array, Array]:
    """n points of a turned square lattice: all at different places on either segment."""
    k = np.arange(n) - n // 2
    return k / n, ((step * k + n // 2) % n - n // 2) / n


def points(scene: Scene, law: Slope, cutoff: float, rule: tuple[Array, Array]) -> Found:
    """Sums over point pairs."""
    s, t = rule
    force = np.zeros((len(scene.own), 3))
    pairs = evaluations = 0
    for q, i in enumerate(scene.own):
        js = scene.others(i, cutoff + T)
        swap = (js < i)[:, None]
        mine, theirs = np.where(swap, t, s) * T, np.where(swap, s, t) * T
        d = (scene.x[i] + mine[..., None] * scene.e[i]
             - scene.x[js][:, None] - theirs[..., None] * scene.e[js][:, None])
        r = np.linalg.norm(d, axis=2)
        inside = r < cutoff
        force[q] = (np.where(inside, -law(r) / r, 0)[..., None] * d).sum((0, 1)) / len(s)
        met = inside.any(axis=1).sum()
        pairs += met
        evaluations += met * len(s)
    return Found(force, pairs / 2 / len(scene.own), evaluations / 2 / len(scene.own))


def line_table() -> tuple[Array, Array, Array]:
    """W(rho), the energy of a point beside an endless line, per length of a segment, and W'."""
    rho = np.linspace(8.0, CUTOFF, 4001)
    along = np.linspace(-CUTOFF, CUTOFF, 4001)
    w = energy(np.hypot(rho[:, None], along)).sum(axis=1) * (along[1] - along[0]) / T
    return rho, w, np.gradient(w, rho)


RHO, LINE, LINE_SLOPE = line_table()


def hand_over(x: Array) -> tuple[Array, Array]:
    """phi(x) = 1 - S(|x|), which hands a point from one segment to the next, and its slope."""
    y = np.clip(np.abs(x), 0, 1)
    return 1 - independent.step(y), -np.sign(x) * 30 * y**2 * (1 - y)**2


def line_force(p: Array, x: Array, e: Array, bent: Array) -> tuple[Array, Array]:
    """Gradient of phi(t/T) W(rho) (1 - n.kappa)^(-1/2) with respect to the points p, n the way from
    the foot to p, for lines through x along e with the curvature kappa; and which are in reach."""
    d = p - x
    t = (d * e).sum(-1)
    across = d - t[..., None] * e
    rho = np.linalg.norm(across, axis=-1)
    phi, change = hand_over(t / T)
    inside = (rho < CUTOFF) & (np.abs(t) < T)
    w, dw = np.interp(rho, RHO, LINE), np.interp(rho, RHO, LINE_SLOPE)
    factor = np.maximum(1 - (across * bent).sum(-1), 0.2)**-0.5
    gradient = ((change / T * w * factor)[..., None] * e
                + (phi * dw * factor / np.maximum(rho, 1e-9))[..., None] * across
                + (0.5 * phi * w * factor**3)[..., None] * bent)
    return np.where(inside[..., None], gradient, 0), inside


def curvature(scene: Scene) -> Array:
    """Of the fibre at each segment, from the axes of its neighbours; across the segment's axis."""
    kappa = np.zeros_like(scene.e)
    inner = np.nonzero((scene.fibre[2:] == scene.fibre[:-2]))[0] + 1
    kappa[inner] = (scene.e[inner + 1] - scene.e[inner - 1]) / (2 * T)
    return kappa - (kappa * scene.e).sum(1)[:, None] * scene.e


def lines(scene: Scene, n: int, curved: bool) -> Found:
    """Points of each segment against the line through the other one."""
    kappa = curvature(scene) * curved
    place = (np.arange(n) - 0.5 * (n - 1)) / n * T
    force = np.zeros((len(scene.own), 3))
    pairs = evaluations = 0
    for q, i in enumerate(scene.own):
        js = scene.others(i, CUTOFF + 2 * T)
        mine = scene.x[i] + place[:, None] * scene.e[i]
        theirs = scene.x[js][:, None] + place[:, None] * scene.e[js][:, None]
        on_mine, one = line_force(mine[None], scene.x[js][:, None], scene.e[js][:, None],
                                  kappa[js][:, None])
        on_theirs, two = line_force(theirs, scene.x[i], scene.e[i], kappa[i])
        force[q] = 0.5 / n * (on_theirs.sum((0, 1)) - on_mine.sum((0, 1)))
        met = (one | two).any(axis=1).sum()
        pairs += met
        evaluations += met * 2 * n
    return Found(force, pairs / 2 / len(scene.own), evaluations / 2 / len(scene.own))


def bundle(rng: np.random.Generator) -> list[Scene]:
    """37 straight tubes side by side, slightly disordered: segments in the middle, at the ends."""
    x, e, fibre = [], [], []
    count = 16
    for f, place in enumerate(generators.hexagon(17.07, 3)):
        z = (np.arange(count) + rng.random()) * T
        x.append(np.stack([z, np.full(count, place[0]), np.full(count, place[1])], 1)
                 + 0.02 * rng.standard_normal((count, 3)))
        e.append(np.stack([np.ones(count), *(0.002 * rng.standard_normal((2, count)))], 1))
        fibre += [f] * count
    axes = np.concatenate(e)
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    whole = np.concatenate(x), axes, np.array(fibre)
    first = np.arange(0, len(fibre), count)
    return [Scene("bundle", *whole, first + count // 2), Scene("ends", *whole, first)]


def weave(rng: np.random.Generator) -> Scene:
    """4 x 4 tubes of 20 segments, five between crossings."""
    x, e, fibre = [], [], []
    s = (np.arange(20) + 0.5) * T - 10 * T
    for f in range(8):
        sign, wave = (1 if f % 2 else -1), np.pi / (5 * T)
        height, tilt = 8.6 * sign * np.sin(wave * s), 8.6 * wave * sign * np.cos(wave * s)
        place, none = np.full(20, (f % 4 - 1.5) * 5 * T), np.zeros(20)
        if f < 4:
            x.append(np.stack([s, place, height], 1))
            e.append(np.stack([none + 1, none, tilt], 1))
        else:
            x.append(np.stack([place, s, -height], 1))
            e.append(np.stack([none, none + 1, -tilt], 1))
        fibre += [f] * 20
    axes = np.concatenate(e)
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    where = np.concatenate(x) + 0.02 * rng.standard_normal((160, 3))
    return Scene("weave", where, axes, np.array(fibre), rng.choice(160, 60, replace=False))


def split(scene: Scene, n: int) -> Found:
    many, few = points(scene, near, FROM, product(n)), points(scene, far, CUTOFF, product(1))
    return Found(many.force + few.force, few.pairs, many.evaluations + few.evaluations)


WAYS: dict[str, Callable[[Scene], Found]] = {
    **{f"{n} x {n} points": lambda scene, n=n: points(scene, slope, CUTOFF, product(n))
       for n in (3, 4, 5)},
    **{f"split, {n} points and 1": lambda scene, n=n: split(scene, n) for n in (3, 4, 5)},
    **{f"line, {n} points{', curved' if c else ''}": lambda scene, n=n, c=c: lines(scene, n, c)
       for c in (False, True) for n in (1, 2, 3)},
    **{f"lattice of {n}": lambda scene, n=n, k=k: points(scene, slope, CUTOFF, lattice(n, k))
       for n, k in ((13, 5), (25, 7))}}


def main() -> None:
    rng = np.random.default_rng(3)
    scenes = [*bundle(rng), weave(rng)]
    exact = [points(scene, slope, CUTOFF, product(15)).force for scene in scenes]
    print("| | " + " | ".join(f"{s.name}: error" for s in scenes)
          + " | bundle: pairs | evaluations | weave: pairs | evaluations |")
    print("|---" * 8 + "|")
    for name, way in WAYS.items():
        found = [way(scene) for scene in scenes]
        errors = [np.sqrt(((f.force - x)**2).sum() / (x**2).sum()) for f, x in zip(found, exact)]
        counts = [f"{f.pairs:.1f} | {f.evaluations:.0f}" for f in (found[0], found[2])]
        print(f"| {name} | " + " | ".join(f"{e:.2g}" for e in errors) + " | "
              + " | ".join(counts) + " |")


if __name__ == "__main__":
    main()
