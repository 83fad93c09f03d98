"""Contacts at the closest approach, friction and walls."""
import math

import numpy as np

from .. import states, tables
from ..beams import TUBE
from ..rotations import no_rotation, rotation_about
from ..units import GPA
from .common import Row, new_folder, order, relative, simulate, write_state

T, RADIUS = TUBE.T, TUBE.radius
CONTACTS, FRICTION, WALLS = "contacts", "friction", "walls"
MODULUS = 20.0  # E*, GPa
# What presses a segment of a bar on two rods, their friction, and how fast 1.2 of it draws.
PRESS, BAR_FRICTION = 0.002, 0.3
COULOMB = 0.2 * BAR_FRICTION * PRESS / TUBE.m
TOUCH = f"-scene file -scene_file {{dir}}/in.h5 -pair contact -contact_modulus {MODULUS:g} "


def straight(start, axis, count, length=T):
    """A straight fibre of segments of this length along x (0) or y (1)."""
    x = np.tile(np.asarray(start, float), (count, 1))
    x[:, axis] += length * np.arange(count)
    turn = no_rotation(count) if axis == 0 else rotation_about((0, 0, 1),
                                                              np.full(count, math.pi / 2))
    return x, turn


def crossed_force(name, place, length=T):
    """Between two fibres crossed at a right angle `place` segments off a centre, over Hertz's."""
    folder, overlap = new_folder(name), 0.05
    exact = 4 / 3 * MODULUS * GPA * math.sqrt(RADIUS) * overlap**1.5
    write_state(folder / "in.h5", [
        straight(((place - 3) * length, 0, 0), 0, 7, length),
        straight((0, -3.1 * length, 2 * RADIUS - overlap), 1, 7, length)])
    simulate(folder.name, TOUCH + f"-fibre_segment_length {length!r} -ts_max_steps 0 "
             "-state_output {dir}/out.h5 -state_forces")
    return states.read(folder / "out.h5")["force"][7:, 2].sum() / exact


def crossed():
    """Force between two fibres crossed at a right angle, wherever along a segment."""
    what = "crossed fibres that meet {:g} T off a centre: force over Hertz's"
    return [relative(CONTACTS, what.format(place),
                     1.0, crossed_force(f"contact_crossed_{place:g}", place), 1e-8, "round-off")
            for place in (0.0, 0.23, 0.5)]


def collision():
    """Order in the step of the energy that a collision of two fibres changes."""
    steps, errors = (16.0, 8.0, 4.0), []
    for dt in steps:
        folder = new_folder(f"contact_collision_{dt:g}")
        write_state(folder / "in.h5", [straight((-5.3 * T, 0, 0), 0, 11),
                                       straight((0, -4.7 * T, 2 * RADIUS + 0.1), 1, 10)])
        state = states.read(folder / "in.h5")
        state.rows["velocity"] = np.zeros((21, 3))
        state.rows["velocity"][:, 2] = np.where(state["fibre"] == 0, 2e-4, -2e-4)
        states.write(folder / "in.h5", state)
        simulate(folder.name, TOUCH + f"-ts_dt {dt:g} -ts_max_time 16000 "
                 "-energy_monitor ascii:{dir}/energy.csv -monitor_interval 10")
        energy = tables.read(folder / "energy.csv")
        errors.append(np.abs(energy["total"] - energy["total"][0]).max() / energy["kinetic"][0])
    found = order(errors)
    return [Row(CONTACTS, "collision of two fibres: order of the energy's error", 2.0, found,
                abs(found - 2), 0.2, "next order, at steps of 8 and 4 fs")]


def drawn(name, dt, options=""):
    """Acceleration of a bar that is drawn over two rods by 1.2 of its friction, over that of
    Coulomb's law."""
    press, friction = PRESS, BAR_FRICTION
    speed, ends = [], (1e5, 2e5)
    for end in ends:
        folder = new_folder(f"{name}_{end:g}")
        write_state(folder / "in.h5", [straight((2.3 * T, -3 * T, 0), 1, 7),
                                       straight((8.7 * T, -3 * T, 0), 1, 7),
                                       straight((0, 0, 2 * RADIUS - 0.05), 0, 12)],
                    [1] * 14 + [2] * 12)
        simulate(folder.name, TOUCH + f"-contact_friction {friction} -contact_restitution 0.3 "
                 f"{options} "
                 "-bc rods,bar -rods_group 0 -rods_fix 1,1,1 -rods_fix_rotation -bar_group 1 "
                 f"-bar_force {1.2 * friction * press!r},0,{-press!r} -ts_dt {dt:g} "
                 f"-ts_max_steps {round(end / dt)} -state_output {{dir}}/out.h5")
        speed.append(states.read(folder / "out.h5")["velocity"][14:, 0].mean())
    return (speed[1] - speed[0]) / (ends[1] - ends[0]) / COULOMB


def bar():
    """A bar that is drawn over two rods."""
    return [relative(FRICTION, "bar drawn by 1.2 of its friction: acceleration, A/fs^2",
                     COULOMB, COULOMB * drawn("friction_bar", 10), 1e-2, "the bar shakes")]


def speed_over(name, pull, radius, friction):
    """How fast a limp fibre goes over a fixed rod by half a turn, drawn by 1 and by `pull`."""
    folder, r, free = new_folder(name), radius + RADIUS - 0.02, 14 * T
    half = math.pi * r
    s = (np.arange(math.ceil((2 * free + half) / T - 0.5)) + 0.5) * T - free
    turned = np.clip(s / r, 0, math.pi)
    beyond = np.where(s < 0, s, np.maximum(0, s - half))
    sine, cosine, zero = np.sin(turned), np.cos(turned), 0 * s
    x = r * np.stack([sine, cosine, zero], 1) + beyond[:, None] * np.stack([cosine, -sine, zero], 1)
    group = np.zeros(len(s), int)
    group[0], group[-1] = 1, 2
    write_state(folder / "in.h5", [(x, rotation_about((0, 0, 1), -turned))], group)
    simulate(name, "-scene file -scene_file {dir}/in.h5 -pair none -start_unchecked "
             "-fibre_bond_stiffness 60,20,-4,1.5 -walls rod -rod_shape cylinder -rod_point 0,0,0 "
             f"-rod_axis 0,0,1 -rod_modulus 50 -rod_friction {friction} -rod_restitution 0.5 "
             f"-rod_radius {radius:g} -bc a,b -a_group 0 -a_force -1,0,0 -a_ramp 200000 -b_group 1 "
             f"-b_ramp 200000 -b_force {-pull!r},0,0 -damping_local 0.5 -ts_dt 10 "
             "-ts_max_steps 60000 -state_output {dir}/out.h5")
    return float(np.linalg.norm(states.read(folder / "out.h5")["velocity"][-1]))


def capstan():
    """A fibre over a rod rests 1 % below the closed form's ratio of tensions
    and slides 1 % above."""
    radius, friction = 150.0, 0.3
    # Friction acts at the rod's surface, tension at the fibre's axis.
    most = math.exp(friction * math.pi * radius / (radius + RADIUS))
    below, above = (speed_over(f"friction_capstan_{share:g}", share * most, radius, friction)
                    for share in (0.99, 1.01))
    return [Row(FRICTION, "fibre over a rod at 0.99 of exp(mu phi R/(R + rf)): speed, A/fs", 0.0,
                below, below, 1e-6, "it rests"),
            Row(FRICTION, "the same at 1.01: speed beyond 1e-6 A/fs", 1e-6, above,
                float(np.maximum(0.0, 1e-6 - above)), 1e-12, "it slides")]


def pressed(name, length=T):
    """Depth of a fibre pressed on a floor, over that of Hertz's line, and the force on the floor
    over what presses."""
    press, folder = 0.01, new_folder(name)
    write_state(folder / "in.h5", [straight((0, 0, RADIUS), 0, 10, length)], [1] * 10)
    simulate(name, "-scene file -scene_file {dir}/in.h5 -pair none -walls floor "
             f"-floor_point 0,0,0 -floor_axis 0,0,1 -floor_modulus {MODULUS:g} "
             f"-bc all -all_group 0 -all_force 0,0,{-press} -damping_local 0.5 -ts_dt 10 "
             f"-ts_max_steps 10000 -fibre_segment_length {length!r} "
             "-wall_monitor ascii:{dir}/walls.csv -monitor_interval 1000 "
             "-state_output {dir}/out.h5")
    depth = RADIUS - states.read(folder / "out.h5")["position"][:, 2].mean()
    return (depth / (press / (math.pi / 4 * MODULUS * GPA * length)),
            tables.read(folder / "walls.csv")["floor_force_z"][-1] / (-10 * press))


def floor():
    """A fibre pressed on a floor."""
    depth, force = pressed("wall_floor")
    return [relative(WALLS, "fibre pressed on a floor: depth over that of Hertz's line", 1.0, depth,
                     1e-6, "rest of damping"),
            relative(WALLS, "the same: force on the floor over what presses", 1.0, force, 1e-6,
                     "rest of damping")]


CHECKS = {"contacts_crossed": crossed, "contacts_collision": collision, "friction_bar": bar,
          "friction_capstan": capstan, "walls_floor": floor}
