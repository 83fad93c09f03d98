"""Free vibration: frequencies of bending, stretching and twisting, undamped,
from the phase of one mode."""
import glob
import math

import numpy as np

from .. import states
from ..beams import TUBE
from ..rotations import matrices, rotation_about
from . import linear
from .bending import order_row
from .common import CURVES, Row, in_plane, new_folder, relative, richardson, simulate, write_state

T, DT = TUBE.T, 20.0


def frequency(name, start, groups, options, project, guess, periods=3):
    """Frequency of the oscillation that starts with `start` at rest, freed of Verlet's own shift.

    Verlet moves x(k) = cos(k a), v(k) = -sin(a)/dt sin(k a) with sin(a/2) = omega dt/2 for any
    linear mode. `project` gives the mode's coordinate and its velocity; the phase grows by a in
    each step."""
    folder = new_folder(name)
    write_state(folder / "in.h5", [start], groups)
    interval = max(1, round(2 * math.pi / guess / DT / 12))
    simulate(name, "-scene file -scene_file {dir}/in.h5 -pair none " + options + f" -ts_dt {DT} "
             f"-snapshot_file {{dir}}/s -snapshot_interval {interval} "
             f"-ts_max_steps {12 * periods * interval}")
    seen = [states.read(file) for file in sorted(glob.glob(str(folder / "s_*.h5")))]
    steps = np.array([state.step for state in seen], float)
    q, p = np.array([project(state) for state in seen]).T
    a = guess * DT
    for _ in range(6):
        a = np.polyfit(steps, np.unwrap(np.arctan2(-p * DT / math.sin(a), q)), 1)[0]
    return 2 * math.sin(a / 2) / DT


def bending_frequency(name, nodes, held, mode, groups, options, compression=0.0):
    """Measured and the discrete chain's own frequency of one bending mode."""
    squared, shapes = linear.modes(nodes, held, compression)
    omega, shape = math.sqrt(squared[mode]), shapes[:, mode]
    mass = linear.matrices(nodes)[1]
    # A small amplitude: the fibre must not notice that its ends approach.
    shape = shape / np.abs(shape[::2]).max()
    u = 1e-5 * nodes * T * shape
    r = T - compression / TUBE.B1
    x = np.column_stack([np.arange(nodes) * r, np.zeros(nodes), u[::2]])
    weight = mass * shape

    def project(state):
        e1 = matrices(state["orientation"])[:, :, 0]
        now, speed = np.empty(2 * nodes), np.empty(2 * nodes)
        now[::2], now[1::2] = state.whole[:, 2], np.arctan2(e1[:, 2], e1[:, 0])
        speed[::2], speed[1::2] = state["velocity"][:, 2], -state["angular_velocity"][:, 1]
        return weight @ now, weight @ speed

    return frequency(name, (x, in_plane(u[1::2])), groups, options, project, omega), omega


# Roots of the continuum's frequency equation and, for n nodes, the rod's length: masses sit at the
# nodes, so a free end lies half a segment beyond its node.
SUPPORTS = {
    "clamped-free": ((1.875104068711961, 4.694091132974175, 7.854757438237613), lambda n: n - 0.5),
    "free-free": ((4.730040744862704, 7.853204624095838), lambda n: n),
    "pinned": ((math.pi, 2 * math.pi), lambda n: n - 1),
}


def setup(support, nodes):
    """Held degrees of freedom, group bits and options of a support."""
    groups = np.zeros(nodes, int)
    groups[0], groups[-1] = 1, 2
    if support == "clamped-free":
        return [0, 1], groups, "-bc root -root_group 0 -root_fix 1,1,1 -root_fix_rotation"
    if support == "pinned":
        return ([0, 2 * nodes - 2], groups,
                "-bc left,right -left_group 0 -left_fix 1,1,1 -right_group 1 -right_fix 0,1,1")
    return [], None, ""


LINEAR = "square of the amplitude over the length (1e-5) with a factor, and round-off of positions"


def bending(support):
    rows, (roots, length) = [], SUPPORTS[support]
    for mode, root in enumerate(roots):
        # Two rigid motions come first where nothing is held.
        index = mode + (2 if support == "free-free" else 0)
        scaled, errors = [], []
        for n in (10, 20, 40, 80):
            held, groups, options = setup(support, n + 1)
            omega, chain = bending_frequency(f"bending_{support}_{mode + 1}_{n}", n + 1, held,
                                             index, groups,
                                             options)
            L = length(n + 1) * T
            exact = root**2 / L**2 * math.sqrt(TUBE.EJ / TUBE.rho)
            scaled.append((omega / exact, L))
            errors.append(abs(omega / exact - 1))
        rows.append(relative("vibration", f"{support} bending {mode + 1}, 1/fs, chain of 80 bonds",
                             chain, omega, 1e-7, LINEAR))
        limit, doubt = extrapolate(scaled, (2, 3) if support == "pinned" else (2, 4))
        rows.append(Row("vibration", f"{support} bending {mode + 1} over the beam's, limit T = 0",
                        1.0, limit, abs(limit - 1), doubt,
                        "uncertainty of the extrapolation to T = 0"))
        CURVES.setdefault("convergence",
                          {})[f"{support} {mode + 1}"] = list(zip((10, 20, 40, 80), errors))
    return rows


def extrapolate(scaled, powers):
    """Limit and its uncertainty for errors that begin with these powers of 1/L.

    Two fits through three lengths each; the next power, 4 or more, makes them differ by at least
    15 times the error of the last, of which half is left as a margin. The third power at pinned
    ends: the segment at the hinge has all of its inertia where the beam has half of it."""
    value, L = np.array(scaled).T
    fits = [np.linalg.solve(np.column_stack([np.ones(3), *(L[k:k + 3] ** -p for p in powers)]),
                            value[k:k + 3])[0] for k in (0, 1)]
    return fits[1], abs(fits[1] - fits[0]) / 7.5 + 1e-9


def stretching():
    """Axial and torsional modes: cos(pi p (k + 1/2)/n) is an exact mode of n free segments."""
    rows = []
    axial_speed, twist_speed = math.sqrt(TUBE.ES / TUBE.rho), math.sqrt(TUBE.GJp / (TUBE.I / T))
    for kind, speed in (("axial", axial_speed), ("torsional", twist_speed)):
        limits = []
        for n in (10, 20, 40):
            shape = np.cos(math.pi * (np.arange(n) + 0.5) / n)
            chain = 2 * speed / T * math.sin(math.pi / (2 * n))
            x = np.column_stack([np.arange(n) * T, np.zeros(n), np.zeros(n)])
            if kind == "axial":
                start = (x + 1e-5 * shape[:, None] * [1, 0, 0], in_plane(np.zeros(n)))
                project = (lambda s, shape=shape, x=x:
                           (shape @ (s.whole - x)[:, 0], shape @ s["velocity"][:, 0]))
            else:
                start = (x, rotation_about((1, 0, 0), 1e-5 * shape))
                project = (lambda s, shape=shape: (shape @ matrices(s["orientation"])[:, 2, 1],
                                                   shape @ s["angular_velocity"][:, 0]))
            omega = frequency(f"{kind}_{n}", start, None, "", project, chain)
            limits.append(omega / (math.pi * speed / (n * T)))
        rows.append(relative("vibration", f"free-free {kind}, 1/fs, chain of {n} segments", chain,
                             omega, 1e-7, LINEAR))
        limit, doubt = richardson(limits)
        rows.append(Row("vibration", f"free-free {kind} over the rod's, limit T = 0", 1.0, limit,
                        abs(limit - 1), doubt + 1e-9,
                        "uncertainty of the extrapolation to T = 0, and round-off of the phases"))
        rows.append(order_row("vibration", f"free-free {kind}: order in T",
                              [abs(f - 1) for f in limits]))
    return rows


CHECKS = {f"vibration_{s}": (lambda s=s: bending(s)) for s in SUPPORTS}
CHECKS["vibration_along"] = stretching
