"""Fibres that are not straight at rest: a ring pinched, a helical spring pulled."""
import math

import numpy as np

from .. import states, tables
from ..beams import TUBE, Spring
from ..rotations import rotation_about
from .bending import order_row
from .common import CURVES, Row, new_folder, relative, richardson, simulate, write_state

T = TUBE.T
FAMILY = "rest shapes"
FIRE = "-relax_method fire -ts_max_steps 2000000 -state_output {dir}/out.h5 -pair none "


def ring(count):
    """A regular polygon with sides of length T, and its corners' radius."""
    radius, angle = 0.5 * T / math.sin(math.pi / count), 2 * math.pi / count * np.arange(count)
    x = radius * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    return (x, rotation_about((0, 0, 1), angle + math.pi / 2)), radius


def shrinkage(n):
    """Of a ring of n segments at rest, between two opposite forces F along a diameter, over that of
    the smooth ring, (pi/4 - 2/pi) F R^3/EJ; and the elastic energy of the ring at rest, eV."""
    (x, q), radius = ring(n)
    groups = np.zeros(n, int)
    groups[0], groups[n // 2] = 1, 2
    R = n * T / (2 * math.pi)
    exact = (math.pi / 4 - 2 / math.pi) * R**3 / TUBE.EJ
    force = 1e-5 * R / exact
    folder = new_folder(f"rest_ring_{n}")
    write_state(folder / "in.h5", [(x, q)], groups, closed=True)
    simulate(folder.name, "-scene file -scene_file {dir}/in.h5 " + FIRE
             + f"-fibre_rest_curvature 0,{1 / R!r} -relax_force {1e-6 * force!r} -bc a,b "
             f"-a_group 0 -b_group 1 -a_force {-force!r},0,0 -b_force {force!r},0,0 "
             "-energy_monitor ascii:{dir}/energy.csv")
    now = states.read(folder / "out.h5")["position"]
    shrunk = 2 * radius - np.linalg.norm(now[0] - now[n // 2])
    return shrunk / force / exact, tables.read(folder / "energy.csv").elastic[0]


def pinched():
    """A ring at rest that is pinched a little."""
    rows, scaled = [], []
    for n in (20, 40, 80):
        f, rest = shrinkage(n)
        scaled.append(f)
        rows.append(Row(FAMILY, f"elastic energy of a ring at rest, eV, {n} segments", 0.0, rest,
                        abs(rest), 1e-18, "round-off of positions, squared"))
    limit, doubt = richardson(scaled)
    CURVES.setdefault("convergence", {})["ring"] = [(n, abs(f - 1))
                                                    for n, f in zip((20, 40, 80), scaled)]
    rows.append(Row(FAMILY, "pinched ring, deflection over (pi/4 - 2/pi) F R^3/EJ, limit T = 0",
                    1.0, limit, abs(limit - 1), doubt + 2e-5,
                    "uncertainty of the extrapolation, and a load that bends the ring by 1e-5 R"))
    rows.append(order_row(FAMILY, "pinched ring: order in T", [abs(f - 1) for f in scaled]))
    return rows


def spring():
    """A helix of five turns, its ends kept from turning, that is a little pulled: torsion of the
    wire, and with the angle of the pitch some bending."""
    coil, n, force = Spring(), 48, 1e-4
    helix = (f"-fibre_segment_length {coil.wire / coil.turns / n!r} "
             f"-fibre_rest_curvature 0,{coil.curvature!r} -fibre_rest_twist {coil.twist!r} ")
    folder = new_folder("rest_spring")
    simulate(folder.name, f"-scene fibre -fibre_shape rest -fibre_segments {coil.turns * n + 1} "
             f"-fibre_direction 1,0,{coil.slope / coil.radius!r} -pair none -ts_max_steps 0 "
             "-state_output {dir}/in.h5 " + helix)
    before = states.read(folder / "in.h5")["position"]
    ends = [",".join(repr(float(v)) for v in (*(x - 1), *(x + 1))) for x in before[[0, -1]]]
    simulate(folder.name, "-scene file -scene_file {dir}/in.h5 " + FIRE + helix
             + f"-relax_force 1e-9 -bc a,b -a_region {ends[0]} -a_fix 1,1,1 -a_fix_rotation "
             f"-b_region {ends[1]} -b_fix 1,1,0 -b_fix_rotation -b_force 0,0,{force!r}")
    longer = states.read(folder / "out.h5")["position"][-1, 2] - before[-1, 2]
    return [relative(FAMILY, "helical spring of five turns, extension over force, A^2/eV",
                     coil.compliance(), longer / force, 0.02,
                     "ends that do not turn, and 48 segments a turn")]


CHECKS = {"rest_ring": pinched, "rest_spring": spring}
