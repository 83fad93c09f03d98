"""What a number means does not depend on how a fibre is cut: segments of rf, 2 rf and 4 rf."""
import math

import numpy as np

from .. import states, tables
from ..beams import TUBE, Tube
from ..speed_error.independent import elastica_tip
from . import elastica
from .bending import CLAMP, ends, period
from .common import (
    CURVES, Row, in_plane, new_folder, order, relative, settle, simulate, write_state)
from .tubes import best, continuous

TIMES = (0.5, 1, 2)  # T over 2 rf
FAMILY = "segment length"


def name(times):
    return f"T = {2 * times:g} rf"


def tubes(times, slide, distance, diameters=24):
    """Two endless tubes, one of them slid along the other, and their length."""
    n, T = round(diameters / times), times * TUBE.T
    x = np.zeros((n, 3))
    x[:, 0] = np.arange(n) * T
    q = in_plane(np.zeros(n))
    return [(x, q), (x + [slide, distance, 0], q)], n * T


def adhesion():
    """Adhesion per length by default points and range against the integral over both tubes."""
    where, value = best(lambda d: continuous(d, "smooth", True))
    rows = []
    for times in TIMES:
        folder = new_folder(f"length_adhesion_{times:g}")
        fibres, length = tubes(times, 0.3 * times * TUBE.T, where)
        write_state(folder / "in.h5", fibres, period=length, closed=True)
        simulate(folder.name, "-scene file -scene_file {dir}/in.h5 -ts_max_steps 0 "
                 f"-fibre_segment_length {times * TUBE.T!r} "
                 "-energy_monitor ascii:{dir}/energy.csv")
        measured = tables.read(folder / "energy.csv")["pair"][0] / length
        rows.append(relative(FAMILY, f"adhesion, eV/A, {name(times)}: integral over both tubes",
                             value, measured, 2e-3, "default points, far ones above all"))
    return rows


def cantilever():
    """Tip of a cantilever of 20 diameters under P L^2/EJ = 3 against a rod that stretches as the
    chain does. At the clamp the moment is P times the tip's x: a bond bends by T/L times 2.24."""
    load, L, tips, rows = 3, 20 * TUBE.T, [], []
    exact = elastica_tip(load, L)
    angle, x, z = elastica.solve(0, load, 1.43)
    for times in TIMES:
        n, tube = round(20 / times), Tube(length=times * TUBE.T)
        part = len(angle) // n
        start = np.column_stack([x[::part] * L, 0 * x[::part], z[::part] * L])
        dt = 20 * min(times, 1.0)**2
        state = settle(f"length_cantilever_{times:g}", [(start, in_plane(angle[::part]))], ends(n),
                       CLAMP + f"-tip_force 0,0,{load * tube.EJ / L**2!r} -ts_dt {dt} "
                       f"-fibre_segment_length {tube.T!r}", max(period(20) * 20 / dt / 3, 200))
        tips.append(state["position"][-1, [0, 2]] / L)
        bend = load * exact[0] / n
        rows.append(Row(FAMILY, f"cantilever, y/L of the tip, {name(times)} (error: x and y)",
                        exact[1], tips[-1][1], np.hypot(*(tips[-1] - exact)), bend**2 / 12,
                        "a twelfth of the square of the largest bend of a bond"))
    fine, middle, coarse = (tip[1] for tip in tips)
    rate = math.log2((coarse - middle) / (middle - fine))
    rows.append(Row(FAMILY, "cantilever: order in T of y/L of the tip", 2.0, rate, abs(rate - 2),
                    0.15, "terms of fourth order, with 10 bonds"))
    return rows


def strength():
    """Share of fibres of 20 diameters that break at once at a strain of 2 %; critical strains of
    lengths of 2 rf are 3 +- 0.5 %."""
    fibres, strain, rows = 600, 0.02, []
    weaker = 0.5 * math.erfc(0.01 / 0.005 / math.sqrt(2))
    expected = 1 - (1 - weaker)**20
    for times in TIMES:
        folder, T = new_folder(f"length_strength_{times:g}"), times * TUBE.T
        n = round(20 / times)
        x = np.zeros((n + 1, 3))
        x[:, 0] = np.arange(n + 1) * T * (1 + strain)
        q = in_plane(np.zeros(n + 1))
        write_state(folder / "in.h5", [(x + [0, 40.0 * f, 0], q) for f in range(fibres)])
        simulate(folder.name, "-scene file -scene_file {dir}/in.h5 -pair none -ts_dt 0.001 "
                 f"-fibre_segment_length {T!r} -ts_max_steps 1 -energy_alarm 0 "
                 "-break_strain_mean 0.03 -break_strain_std 0.005 -state_output {dir}/out.h5")
        broken = states.read(folder / "out.h5")["bond_broken"].reshape(fibres, -1).any(1).mean()
        rows.append(Row(FAMILY, f"share of fibres of 20 diameters broken at 2 %, {name(times)}",
                        expected, broken, abs(broken - expected),
                        3 * math.sqrt(expected * (1 - expected) / fibres),
                        f"three standard deviations of {fibres} draws"))
    return rows


def fabric():
    """Stress of a small weave pulled by 5 %: one piece cut three ways. Where a grip ends is known
    to a segment, and with it the gage that is pulled."""
    found, gage = [], 810 - 20 * TUBE.radius
    for times in TIMES:
        folder = new_folder(f"length_weave_{times:g}")
        simulate(folder.name, f"-scene weave -weave_fibres 4,4 -weave_segments {round(60 / times)} "
                 f"-weave_pitch 195 -fibre_segment_length {times * TUBE.T!r} -damping_local 0.4 "
                 f"-ts_dt {20 * min(times, 1)**2} -tension_rate 4e-6 -tension_ends -15,795 "
                 "-tension_width 800 -tension_max_strain 0.05 -monitor_interval 20 "
                 "-stress_monitor ascii:{dir}/stress.csv")
        table = tables.read(folder / "stress.csv")
        stress = 0.5 * (table["stress_left_GPa"] + table["stress_right_GPa"])
        late = table["strain"] > 0.04
        found.append(np.polyval(np.polyfit(table["strain"][late], stress[late], 1), 0.05))
        CURVES[f"length_weave_{times:g}"] = np.column_stack([table["strain"], stress])
    return [relative(FAMILY, f"stress of a weave at 5 %, GPa, {name(times)}: that of {name(0.5)}",
                     found[0], stress, (times + 0.5) * TUBE.T / gage,
                     "a segment of both over the gage")
            for times, stress in zip(TIMES[1:], found[1:])]


CHECKS = {"length_adhesion": adhesion, "length_cantilever": cantilever,
          "length_strength": strength, "length_weave": fabric}
