"""Kinds of fibre: tubes of unequal radii, parallel and crossed, against integrals over both axes.

Of radii a and b the law is q w(gap), q = 2 sqrt(a b)/(a + b), with w that of two (10,10) tubes at
the same gap between the surfaces."""
import math
from typing import NamedTuple

import numpy as np

from .. import states, tables
from ..rotations import rotation_about
from .common import Row, in_plane, new_folder, relative, simulate, write_state
from .tubes import CUTOFF, RF, T, best, law

FAMILY = "kinds"
FINE = 1e-6, "points for the integrals, and the law's table"
DEFAULT = 1e-2, "default points, one a segment for pairs far apart"
EQUAL = 2 * RF                     # between the axes of two (10,10) tubes whose surfaces touch
REACH = CUTOFF - EQUAL             # of the law, gap between the surfaces


class Tube(NamedTuple):
    """A straight fibre: its radius and the length of its segments, A."""
    radius: float
    T: float


THIN = Tube(RF, T)
# The (20,20) tube, and others up to a hundred times as thick as the (10,10) tube.
DOUBLE, TEN, HUNDRED = Tube(2 * RF, 2 * T), Tube(10 * RF, 10 * T), Tube(100 * RF, 100 * T)
PAIRS = {"(10,10), (10,10)": (THIN, THIN), "(10,10), (20,20)": (THIN, DOUBLE),
         "1 : 10": (THIN, TEN), "1 : 100": (THIN, HUNDRED), "2 : 10": (DOUBLE, TEN)}


def law_between(a, b, r):
    """Energy per length squared of two fibres at a distance r, eV/A^2."""
    q = 2 * math.sqrt(a.radius * b.radius) / (a.radius + b.radius)
    return q * law(r - a.radius - b.radius + EQUAL, "smooth") / T**2


def integral(f, low, high, parts=4000):
    """Simpson's rule."""
    x, h = np.linspace(low, high, 2 * parts + 1, retstep=True)
    y = f(x)
    return h / 3 * (y[0] + 4 * y[1::2].sum() + 2 * y[2:-1:2].sum() + y[-1])


def along(a, b, distance):
    """Energy per length of two parallel ones, endless."""
    reach = math.sqrt(max((a.radius + b.radius + REACH)**2 - distance**2, 0))
    return 2 * integral(lambda z: law_between(a, b, np.hypot(distance, z)), 0, reach)


def crossed(a, b, distance):
    """Energy of two at a right angle, and the force that drives them apart."""
    energy = 2 * math.pi * integral(lambda r: law_between(a, b, r) * r, distance,
                                    a.radius + b.radius + REACH)
    return energy, 2 * math.pi * distance * float(law_between(a, b, distance))


def row_of(tube, start, reach, axis=0, slide=0.3):
    """A straight fibre through `start` that goes on for `reach` to both sides,
    off by a part of a segment."""
    count = 2 * math.ceil(reach / tube.T) + 2
    x = np.tile(np.array(start, float), (count, 1))
    x[:, axis] += (np.arange(count) - 0.5 * (count - 1) + slide) * tube.T
    q = (in_plane(np.zeros(count)) if axis == 0 else
         rotation_about((0, 0, 1), np.full(count, math.pi / 2)))
    return x, q


def points(a, b):
    """Options for points 2 A apart, or as many as there may be."""
    return "".join(f" -{kind}_pair_points {min(99, math.ceil(tube.T / 2))}"
                   for kind, tube in zip("ab", (a, b)))


def evaluate(folder, tubes, fibres, options="", steps="-ts_max_steps 0"):
    """The program's state, with forces, and first pair energy, of two fibres of two kinds a, b."""
    x = np.concatenate([fibre[0] for fibre in fibres])
    state = states.of_fibres(fibres, x.min(0) - 200 - tubes[1].T, x.max(0) + 200 + tubes[1].T)
    states.write(folder / "in.h5", states.of_kinds(state, ("a", "b"), (0, 1)))
    for kind, tube in zip("ab", tubes):
        options += (f" -{kind}_fibre_radius {tube.radius!r} -{kind}_fibre_density 2000"
                    f" -{kind}_fibre_segment_length {tube.T!r}")
    (folder / "energy.csv").unlink(missing_ok=True)
    simulate(folder.name, "-scene file -scene_file {dir}/in.h5 -kinds a,b "
             "-state_output {dir}/out.h5 -state_forces -energy_monitor ascii:{dir}/energy.csv"
             + f" {steps} {options}")
    return states.read(folder / "out.h5"), tables.read(folder / "energy.csv")["pair"][0]


def adhesion_of(name, a, b, options=""):
    """Adhesion per length of a short fibre of kind a beside a long one of kind b:
    integral, program."""
    where, value = best(lambda d: along(a, b, d), a.radius + b.radius + 2, a.radius + b.radius + 4)
    reach = math.sqrt((a.radius + b.radius + REACH)**2 - where**2)
    short = row_of(a, (0, 0, 0), 8 * T)
    length = len(short[0]) * a.T
    energy = evaluate(new_folder(name), (a, b),
                      (short, row_of(b, (0, where, 0), length / 2 + reach + 2 * b.T)), options)[1]
    return value, energy / length


def adhesion():
    rows = []
    for k, (name, (a, b)) in enumerate(PAIRS.items()):
        what = f"adhesion, eV/A, {name}: integral over both axes"
        rows += [relative(FAMILY, what, *adhesion_of(f"kinds_adhesion_{k}", a, b, points(a, b)),
                          *FINE),
                 relative(FAMILY, what + ", default points",
                          *adhesion_of(f"kinds_default_{k}", a, b), *DEFAULT)]
    return rows


def cut():
    """Either of two kinds cut into shorter or longer segments."""
    rows = []
    for of_a, of_b in ((0.5, 1), (2, 1), (1, 0.5), (1, 2)):
        a, b = Tube(RF, of_a * T), Tube(10 * RF, of_b * 10 * T)
        name = f"segments of {of_a:g} and {of_b:g} diameters"
        rows.append(relative(FAMILY, f"adhesion, eV/A, 1 : 10, {name}: integral over both axes",
                             *adhesion_of(f"kinds_cut_{of_a:g}_{of_b:g}", a, b, points(a, b)),
                             *FINE))
    return rows


def crossing():
    """Two at a right angle, 4.5 A between their surfaces."""
    rows = []
    for k, (name, (a, b)) in enumerate(PAIRS.items()):
        d = a.radius + b.radius + 4.5
        reach = math.sqrt((a.radius + b.radius + REACH)**2 - d**2)
        energy, force = crossed(a, b, d)
        fibres = (row_of(a, (0, 0, 0), reach + 2 * a.T),
                  row_of(b, (0, 0, d), reach + 2 * b.T, 1, 0.2))
        state, found = evaluate(new_folder(f"kinds_crossing_{k}"), (a, b), fibres, points(a, b))
        pushed = state["force"][state["fibre"] == 1, 2].sum()
        rows += [relative(FAMILY, f"crossing, eV, {name}: 2 pi int w r dr", energy, found, *FINE),
                 relative(FAMILY, f"crossing, force, eV/A, {name}: 2 pi d w(d)", force, pushed,
                          *FINE)]
    return rows


def one_fibre():
    """Two kinds that are the same fibre, beside one kind."""
    folder = new_folder("kinds_one")
    fibres = row_of(THIN, (0, 0, 0), 8 * T), row_of(THIN, (0, 17.2, 1.0), 8 * T, 0, 0.1)
    energy = evaluate(folder, (THIN, THIN), fibres)[1]
    write_state(folder / "one.h5", fibres)
    simulate(folder.name, "-scene file -scene_file {dir}/one.h5 -ts_max_steps 0 "
             "-energy_monitor ascii:{dir}/one.csv")
    return [relative(FAMILY, "pair energy, eV, two kinds that are one fibre: one kind",
                     tables.read(folder / "one.csv")["pair"][0], energy, 1e-12,
                     "round-off of the sums")]


def motion():
    """A thin fibre let go 0.3 A beyond its resting distance from one a hundred times as thick,
    undamped."""
    where = best(lambda d: along(THIN, HUNDRED, d), 101 * RF + 2, 101 * RF + 4)[0]
    fibres = row_of(THIN, (0, 0, 0), 8 * T), row_of(HUNDRED, (0, where + 0.3, 0), 8 * T)
    spread = []
    for dt in (20, 10):
        folder = new_folder(f"kinds_motion_{dt}")
        evaluate(folder, (THIN, HUNDRED), fibres,
                 steps=f"-ts_max_steps {4000 // dt} -ts_dt {dt} -monitor_interval {40 // dt}")
        table = tables.read(folder / "energy.csv")
        spread.append(np.ptp(table.balance) / table.motion.max())
    rate = math.log2(spread[0] / spread[1])
    return [Row(FAMILY, "1 : 100 in motion, undamped: spread of the energy over its motion, 10 fs",
                0.0, spread[1], spread[1], 1e-2, "second order in the step"),
            Row(FAMILY, "1 : 100 in motion, undamped: order in the step", 2.0, rate, abs(rate - 2),
                0.3, "terms of fourth order")]


CHECKS = {"kinds_adhesion": adhesion, "kinds_cut": cut, "kinds_crossing": crossing,
          "kinds_one": one_fibre, "kinds_motion": motion}
