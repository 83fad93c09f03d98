"""Twisted fibres that buckle: a straight one under tension, and Michell's ring.

Both hold their twist because they are closed, through a periodic boundary or as a ring, with a
whole number of turns; what varies is the tension, or the shear modulus. The threshold is where the
squared frequency of the buckling mode passes through zero, extrapolated from three runs before it,
and one run beyond it must grow."""
import glob
import math

import numpy as np

from .. import states
from ..beams import TUBE, Tube
from ..rotations import matrices, multiply, rotation_about
from . import evm
from .bending import order_row
from .buckling import zero_of_parabola
from .common import CURVES, Row, new_folder, relative, richardson, simulate, write_state

T, EJ, DT = TUBE.T, TUBE.EJ, 20.0
TURNS = 2


def straight(n, tension, turns=TURNS):
    """A straight fibre along x, stretched by the tension and twisted evenly; its period."""
    r = T + tension / TUBE.B1
    x = np.zeros((n, 3))
    x[:, 0] = np.arange(n) * r
    return TUBE, x, rotation_about((1, 0, 0),
                                   2 * math.pi * turns * np.arange(n) / n), np.array([n * r, 0, 0])


def ring(n, shear):
    """A ring with two turns of twist:
    its radius and the tilt of its segments out of the plane from rest."""
    tube = Tube(shear=shear)
    a = 2 * math.pi * np.arange(n) / n
    twist = rotation_about((1, 0, 0), TURNS * a)
    turn = multiply(rotation_about((0, 0, 1), a),
                    np.tile(rotation_about((0, 0, 1), math.pi / 2), (n, 1)))

    def shape(radius, tilt):
        x = radius * np.column_stack([np.cos(a), np.sin(a), 0 * a])
        tilted = multiply(turn, np.tile(rotation_about((0, 1, 0), tilt), (n, 1)))
        return x, multiply(tilted, twist)

    def push(p):
        x, q = shape(*p)
        total = evm.gradient(x, matrices(q), tube, np.zeros(3))
        # By symmetry what is left is a radial force and a radial torque.
        return np.array([total[0, 0], total[0, 3] / T])

    p = np.array([T / (2 * math.sin(math.pi / n)), 0.0])
    for _ in range(20):
        step = np.array([1e-4, 1e-6])
        slope = np.column_stack([(push(p + s) - push(p - s)) / (2 * s.sum())
                                 for s in np.diag(step)])
        p -= np.linalg.solve(slope, push(p))
    return tube, *shape(*p), np.zeros(3)


def soft_mode(tube, x, q, shift, wave):
    """The lowest mode with so many waves along the fibre: squared frequency and shape."""
    squared, shapes = evm.modes(x, q, tube, shift)
    n = len(x)
    away = x - x.mean(0)
    radial = away / np.linalg.norm(away, axis=1)[:, None]
    share = []
    for shape in shapes[:, :12].T:
        u = shape.reshape(n, 6)[:, :3]
        parts = [u[:, 2], u[:, 1] if shift.any() else np.sum(u * radial, 1)]
        power = sum(np.abs(np.fft.rfft(part))**2 for part in parts)
        share.append(power[wave] / power.sum() if power.sum() > 0 else 0)
    best = next(k for k in range(12) if share[k] > 0.99)
    return squared[best], shapes[:, best]


def squared_frequency(name, tube, x, q, shift, wave, options):
    """Measured and expected; a growing mode has a negative one."""
    expected, shape = soft_mode(tube, x, q, shift, wave)
    n, u = len(x), shape.reshape(len(x), 6)
    # Small: in a box of fixed length a deflection adds tension.
    u = u * (1e-6 * n * T / np.abs(u[:, :3]).max())
    weight = np.tile([tube.m] * 3 + [tube.I] * 3, n) * u.ravel()
    folder = new_folder(name)
    start = (x + u[:, :3], evm.turned(q, u[:, 3:]))
    write_state(folder / "in.h5", [start], closed=True, period=shift[0] if shift.any() else None)
    # An eighth of a period, or a growth by cosh 2, in each of the snapshots' intervals.
    interval = max(1, round(math.pi / 4 / math.sqrt(abs(expected)) / DT))
    simulate(name, "-scene file -scene_file {dir}/in.h5 -pair none " + options + f" -ts_dt {DT} "
             f"-snapshot_file {{dir}}/s -snapshot_interval {interval} -ts_max_steps {4 * interval}")
    amplitude = []
    for file in sorted(glob.glob(str(folder / "s_*.h5"))):
        state = states.read(file)
        moved = np.zeros((n, 6))
        moved[:, :3] = state.whole - x
        back = q * [1, -1, -1, -1]
        turn = multiply(state["orientation"], back)
        moved[:, 3:] = 2 * turn[:, 1:] * np.sign(turn[:, :1])
        amplitude.append(weight @ moved.ravel())
    A = np.array(amplitude)
    # x(k+1) + x(k-1) = 2 cos(a) x(k) for every k, oscillating or growing.
    c = np.sum((A[2:] + A[:-2]) * A[1:-1]) / (2 * np.sum(A[1:-1]**2))
    step = math.acos(c) / interval if abs(c) < 1 else 1j * math.acosh(c) / interval
    return ((2 * np.sin(step / 2) / DT)**2).real, expected


def threshold(family, make, wave, closed_form, parameter, options, sizes, unit):
    """Rows for the critical value of a parameter;
    fractions of the closed form lie on the stable side."""
    rows, ratios = [], []
    for n in sizes:
        value = closed_form(n)
        discrete = value * find_zero(lambda f: soft_mode(*make(n, f * value), wave)[0], 0.95, 1.05)
        side = parameter * np.array([0.05, 0.03, 0.015, -0.02])
        points = discrete * (1 + side)
        pairs = [squared_frequency(f"{family.replace(' ', '_')}_{n}_{k}", *make(n, p), wave,
                                   options(p))
                 for k, p in enumerate(points)]
        measured = zero_of_parabola(points[:3], np.array([m for m, _ in pairs[:3]]))
        own = zero_of_parabola(points[:3], np.array([e for _, e in pairs[:3]]))
        ratios.append(measured / value)
    rows.append(relative(family, f"critical {unit}, chain of {n} bonds", discrete, measured,
                         2 * abs(own / discrete - 1) + 1e-5,
                         "extrapolation to zero of squared frequencies, "
                         "which have 1e-4 of round-off"))
    growth, expected = pairs[3]
    rows.append(relative(family, f"2 % beyond it, {n} bonds: squared frequency 1/fs^2, grows",
                         expected, growth, 1e-4,
                         "round-off of forces: 1e-3 of the small restoring force of a node, "
                         "averaged"))
    limit, doubt = richardson(ratios)
    rows.append(Row(family, f"critical {unit} over the closed form, limit T = 0", 1.0, limit,
                    abs(limit - 1), doubt + 2 * abs(own / discrete - 1),
                    "uncertainty of both extrapolations"))
    rows.append(order_row(family, "order in T", [abs(r - 1) for r in ratios]))
    CURVES.setdefault("convergence", {})[family] = [(n, abs(r - 1)) for n, r in zip(sizes, ratios)]
    return rows


def find_zero(function, low, high):
    fl, fh = function(low), function(high)
    for _ in range(40):
        middle = low - fl * (high - low) / (fh - fl)
        f = function(middle)
        if abs(f) < 1e-9 * max(abs(fl), abs(fh)) or abs(high - low) < 1e-10:
            break
        low, fl, high, fh = middle, f, low, fl
    return middle


def under_tension():
    """Deflection y + i z = exp(i b s): EJ b^2 - M b + N = 0 for the one wave b = 2 pi/L that fits.

    With M = G Jp 2 pi turns/L: N = (2 pi/L)^2 (turns G Jp - EJ).
    The least M over all b is M^2 = 4 EJ N."""
    def tension(n):
        return (2 * math.pi / (n * T))**2 * (TURNS * TUBE.GJp - EJ)
    return threshold("twist under tension", straight, 1, tension, 1, lambda p: "", (20, 40, 80),
                     "tension")


def michell():
    """Twist 2 pi sqrt(3) EJ/(G Jp) = 2 pi turns at G Jp = sqrt(3) EJ/turns; stable below."""
    def shear(n):
        return 459.0 * math.sqrt(3) * EJ / TURNS / TUBE.GJp
    return threshold("Michell's ring", ring, 2, shear, -1, lambda p: f"-fibre_shear {p!r}",
                     (20, 40, 80),
                     "shear modulus")


CHECKS = {"twist_under_tension": under_tension, "michell": michell}
