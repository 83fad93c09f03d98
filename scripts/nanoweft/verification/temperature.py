"""Temperature: fluctuations in equilibrium, within four standard errors of the samples averaged."""
import math

import numpy as np

from .. import states, tables
from ..rotations import matrices
from . import linear
from .bending import straight
from ..beams import TUBE, Tube
from .common import Row, new_folder, relative, simulate, write_state

T, KT = TUBE.T, 8.617333262e-5 * 300
FAMILY = "temperature"
HEATED = "-scene file -scene_file {dir}/in.h5 -pair none -ts_limit_interval 0 -temperature 300 "


def many(name, fibres, segments):
    """A folder with in.h5: straight fibres side by side, along x from x = 0 on."""
    folder = new_folder(name)
    x, q = straight(segments - 1), np.tile([1.0, 0, 0, 0], (segments, 1))
    write_state(folder / "in.h5", [(x + [0, 50.0 * k, 0], q) for k in range(fibres)])
    return folder


def snapshots(folder, options, interval, begin, end):
    """The states at the multiples of the interval, from number `begin` on."""
    simulate(folder.name, HEATED + options + " -snapshot_file {dir}/s "
             f"-snapshot_interval {interval} -ts_max_steps {end * interval}")
    return [states.read(folder / f"s_{k * interval:010d}.h5") for k in range(begin, end + 1)]


def within(name, expected, measured, samples, reason):
    """A mean of squares of `samples` independent normal numbers."""
    return relative(FAMILY, name, expected, measured, 4 * math.sqrt(2 / samples),
                    f"four standard errors of {samples} samples: {reason}")


def warm(name, dt, fibres, segments):
    """Energies of fibres at 300 K, rows 500 fs apart."""
    folder = many(name, fibres, segments)
    every = math.ceil(500 / dt)
    simulate(folder.name, HEATED + "-temperature_damping 0.02 -temperature_start "
             f"-ts_dt {dt} -ts_max_steps {400 * every} -monitor_interval {every} "
             "-energy_monitor ascii:{dir}/energy.csv")
    return tables.read(folder / "energy.csv")


def stretching(table, fibres, segments):
    """Energy of a bond's stretching over kT/2; slow modes remember four rows."""
    begin = len(table) // 4
    return table["stretch"][begin:].mean() / (fibres * (segments - 1) * KT / 2)


def equipartition():
    rows, segments, fibres = [], 10, 100
    for dt in (10, 35):
        table = warm(f"temperature_motion_{dt}", dt, fibres, segments)
        count = 3 * fibres * segments
        for part, what in (("kinetic", "translation"), ("rotational", "rotation")):
            rows.append(within(f"{what}, step of {dt} fs: temperature, K", 300,
                               300 * table[part].mean() / (count * KT / 2), count * len(table),
                               "rows 500 fs apart, where velocities forget within 100 fs"))
        # Axial modes of the free chain, each too large by 1/(1 - (omega dt/2)^2).
        swing = np.sqrt(TUBE.B1 / TUBE.m) * np.sin(np.arange(1, segments) * math.pi / 2 / segments)
        expected = np.mean(1 / (1 - (swing * dt)**2))
        rows.append(within(f"stretching of a bond, step of {dt} fs: energy over kT/2", expected,
                           stretching(table, fibres, segments),
                           fibres * (segments - 1) * (len(table) - len(table) // 4) // 4,
                           "slow modes remember four rows"))
    return rows


def tip():
    fibres, bonds, dt = 300, 6, 20
    folder = many("temperature_tip", fibres, bonds + 1)
    found = snapshots(folder, f"-temperature_damping 0.001 -ts_dt {dt} -bc root -root_region "
                      "-1,-1e9,-1,1,1e9,1 -root_fix 1,1,1 -root_fix_rotation", 300, 5, 80)
    x = np.array([s["position"].reshape(fibres, bonds + 1, 3) for s in found])
    u = (x[:, :, -1] - x[:, :, 0])[:, :, 1:]
    L = bonds * T
    rows = [within("tip of a clamped fibre of 6 bonds: <u^2>, A^2", KT * L**3 / (3 * TUBE.EJ),
                   (u**2).mean(), u.size, "snapshots 3/omega of the slowest mode apart")]
    squared, shapes = linear.modes(bonds + 1, [0, 1])
    rise = KT * (shapes[2 * bonds]**2 / squared / (1 - squared * dt**2 / 4)).sum()
    if abs(rise / (KT * L**3 / (3 * TUBE.EJ)) - 1) > 1e-3:
        raise RuntimeError("the modes of the fibre do not add up to its compliance")
    return rows


def persistence():
    fibres, segments, apart = 100, 21, 10
    share = 100 * T * KT / TUBE.EJ
    tube = Tube(1029 * share, 459 * share)
    folder = many("temperature_persistence", fibres, segments)
    found = snapshots(folder, f"-temperature_damping 3e-5 -ts_dt 500 -fibre_young {1029 * share!r} "
                      f"-fibre_shear {459 * share!r}", 250, 8, 80)
    e1 = np.array([matrices(s["orientation"])[:, :, 0] for s in found])
    e1 = e1.reshape(len(found), fibres, segments, 3)
    mean = (e1[:, :, apart:] * e1[:, :, :-apart]).sum(3).mean()
    stretches = 2 * fibres * len(found)
    return [relative(FAMILY, "persistence length of a soft fibre, A", tube.EJ / KT,
                     -apart * T / math.log(mean), 4 / math.sqrt(stretches) + 0.01,
                     f"four standard errors of {stretches} stretches, and a chain's T over it")]


def diffusion():
    fibres, segments, gamma, window = 1000, 3, 2e-3, 10000
    folder = many("temperature_diffusion", fibres, segments)
    found = snapshots(folder, f"-temperature_damping {gamma} -temperature_start -ts_dt 20", 500, 0,
                      20)
    centre = np.array([s["position"].reshape(fibres, segments, 3).mean(1) for s in found])
    step = np.diff(centre, axis=0)
    time = 2 * (window - (1 - math.exp(-gamma * window)) / gamma)
    return [within("free fibre of 3 segments: diffusion, A^2/fs", KT / (segments * TUBE.m * gamma),
                   (step**2).mean() / time, step.size, "windows of 20/gamma")]


def balance():
    """What the books of a fibre that warms up from rest miss, by the step."""
    errors = []
    for dt in (10, 5):
        folder = many(f"temperature_balance_{dt}", 100, 10)
        simulate(folder.name, HEATED + f"-temperature_damping 0.001 -ts_dt {dt} -ts_max_time 20000 "
                 "-monitor_interval 10 -energy_monitor ascii:{dir}/energy.csv")
        table = tables.read(folder / "energy.csv")
        errors.append(np.abs(table.balance - table.balance[0]).max() / table["heat"][-1])
    return [Row(FAMILY, "warming up from rest: imbalance over the heat, 5 fs", 0, errors[1],
                errors[1], errors[0] / 2, "half of that at 10 fs")]


CHECKS = {"temperature_equipartition": equipartition, "temperature_tip": tip,
          "temperature_persistence": persistence, "temperature_diffusion": diffusion,
          "temperature_balance": balance}
