"""What holders feel: torque of a twisted rope, stress of a tube that is pulled and let go."""
import math

import numpy as np

from .. import tables
from ..beams import TUBE
from .common import Row, in_plane, new_folder, relative, simulate, write_state

T = TUBE.T
HELD, PROGRAM = "holders", "tension programs"


def spun(name, places, dt=12):
    """Angle, groups and energies of parallel tubes of 20 bonds twisted about the x axis."""
    n, spin, ramp, steps = 21, 1e-5, 2e4, round(96000 / dt)
    folder = new_folder(name)
    fibres = [(np.column_stack([np.arange(n) * T, np.full(n, y), np.full(n, z)]),
               in_plane(np.zeros(n))) for y, z in places]
    ends = ([1] + (n - 2) * [0] + [2]) * len(places)
    write_state(folder / "in.h5", fibres, ends)
    simulate(name, "-scene file -scene_file {dir}/in.h5 -bc root,tip -root_group 0 "
             "-root_fix 1,1,1 -root_fix_rotation -tip_group 1 "
             f"-tip_spin {spin!r} -tip_ramp {ramp!r} -tip_axis 1,0,0 "
             f"-tip_centre 0,0,0 -ts_dt {dt} -ts_max_steps {steps} -monitor_interval 10 "
             "-group_monitor ascii:{dir}/groups.csv -energy_monitor ascii:{dir}/energy.csv")
    groups, energy = tables.read(folder / "groups.csv"), tables.read(folder / "energy.csv")
    time = groups["time_fs"]
    angle = spin * np.where(time < ramp, time**2 / (2 * ramp), time - ramp / 2)
    return angle, groups, energy


APART = 17.0716 / math.sqrt(3)
ROPE = [(APART * math.cos(a), APART * math.sin(a)) for a in 2 * math.pi / 3 * np.arange(3)]


def torque():
    """Torque of a turned end against the sine law of a tube, and the slope of a rope's energy."""
    angle, groups, energy = spun("spun_tube", [(0.0, 0.0)])
    late = angle > 0.5
    ratio = np.mean(groups["tip_torque_x"][late] / (TUBE.B4 * np.sin(angle[late] / 20)))
    rows = [relative(HELD, "spun tube: torque over B4 sin(angle/20), mean from 0.5 rad on",
                     1.0, float(ratio), 2e-3, "waves that the start leaves behind")]
    angle, groups, energy = spun("spun_rope", ROPE)
    gained = energy["total"] - energy["total"][0]
    twist = np.trapz(groups["tip_torque_x"], angle)
    rows.append(relative(HELD, "three tubes twisted: torque over the angle, eV",
                         float(gained[-1]), float(twist), 1e-3, "rows every tenth step"))
    work = groups["tip_work"][-1] + groups["root_work"][-1]
    rows.append(relative(HELD, "the same: work of both ends, eV", float(gained[-1]),
                         float(work), 1e-5, "second order in the step"))
    return rows


def cycle():
    """A tube of 17 free bonds that is pulled and let go, elastic and beyond its yield strain."""
    common = ("-scene fibre -fibre_segments 20 -pair none -tension_grip 14 -tension_width 20 "
              "-tension_thickness 10 -ts_dt 15 -monitor_interval 20 "
              "-stress_monitor ascii:{dir}/stress.csv -energy_monitor ascii:{dir}/energy.csv ")
    part = (19 * T - 28) / (17 * T)  # strain of a bond over that of the gage
    folder = new_folder("cycle_elastic")
    simulate(folder.name, common + "-tension_program 0.01,5e-7,-0.01,5e-7,0,5e-7")
    energy = tables.read(folder / "energy.csv")
    most = 0.5 * 17 * TUBE.ES * T * (0.01 * part)**2
    rest = float(energy["external"][-1]) / most
    rows = [Row(PROGRAM, "tube to 1 %, -1 % and back: work of the grips over that at 1 %", 0.0,
                rest, abs(rest), 1e-3, "waves that turning leaves behind")]
    folder = new_folder("cycle_plastic")
    simulate(folder.name, common + "-fibre_yield_strain 0.005 "
             "-tension_program 0.02,5e-7,0.013,5e-7")
    stress = tables.read(folder / "stress.csv")
    mean = (stress["stress_left_GPa"] + stress["stress_right_GPa"]) / 2
    back = int(np.argmax(stress["strain"]))
    kept = np.interp(0, -mean[back:], stress["strain"][back:]) * part
    rows.append(relative(PROGRAM, "tube that yields at 0.5 %, pulled to 2 %: strain that stays",
                         0.02 * part - 0.005, float(kept), 5e-3,
                         "waves that turning leaves behind"))
    return rows


CHECKS = {"holders": torque, "programs": cycle}
