"""The driven periodic box: stresses, shear by images that slide, and the balance of its work."""
import math

import numpy as np

from .. import states, tables
from ..beams import TUBE
from ..rotations import no_rotation, rotation_about
from ..units import GPA
from .common import Array, Row, new_folder, order, relative, simulate

T = TUBE.T
FAMILY = "driven box"
NODES, APART, SPRING, THICKNESS = 8, 60.0, 2.0, 10.0
# lambda = mu of a triangular lattice of springs, GPa.
LAME = math.sqrt(3) / 4 * SPRING / THICKNESS / GPA


def hooke() -> list[Row]:
    """Stress of a box that is strained with one fibre through it."""
    folder = new_folder("box_hooke")
    simulate(folder.name, "-scene fibre -fibre_segments 40 -fibre_closed -domain_lower 0,-100,-100 "
             f"-domain_upper {40 * T!r},100,100 -domain_periodic 1,0,0 -pair none -ts_dt 20 "
             "-deform_x rate -deform_x_rate 1e-6 -deform_x_until 0.005 -ts_max_steps 400 "
             "-box_monitor ascii:{dir}/box.csv -monitor_interval 20")
    stress = tables.read(folder / "box.csv")["xx_GPa"][-1]
    return [relative(FAMILY, "fibre strained with its box by 0.5 %: stress, GPa",
                     TUBE.ES * 0.005 / 4e4 / GPA, stress, 1e-9, "round-off")]


def deformed(name: str, off: float, options: str) -> dict[str, tables.Table]:
    """Tables of a triangular lattice of springs, whose nodes are displaced by up to `off`."""
    folder, n = new_folder(name), NODES
    i, j = (c.ravel() for c in np.meshgrid(np.arange(n), np.arange(n)))
    rise = APART * math.sqrt(0.75)
    x = np.column_stack([(i + 0.5 * (j % 2) + 0.1) * APART, (j + 0.1) * rise, 0 * i])
    x[:, :2] += np.random.default_rng(3).uniform(-off, off, (n * n, 2))
    order_of = {(int(p), int(q)): m for m, (p, q) in enumerate(zip(i, j))}
    ends = [[[m, 0], [order_of[(p + to) % n, (q + up) % n], 0]] for (p, q), m in order_of.items()
            for to, up in ((1, 0), (q % 2, 1), (q % 2 - 1, 1))]
    states.write(folder / "in.h5", states.of_fibres(
        [(place[None], no_rotation(1)) for place in x], [0, 0, -50], [n * APART, n * rise, 50],
        (1, 1, 0)))
    states.link(folder / "in.h5", ends)
    simulate(name, "-scene file -scene_file {dir}/in.h5 -pair none -link_law spring "
             f"-link_stretch {SPRING} -deform_thickness {THICKNESS} {options} "
             "-box_monitor ascii:{dir}/box.csv -energy_monitor ascii:{dir}/energy.csv")
    return {table: tables.read(folder / f"{table}.csv") for table in ("box", "energy")}


def lattice() -> list[Row]:
    """Elastic constants of a triangular lattice of springs."""
    rows, strain = [], 1e-4
    for axis in ("x", "y", "xy"):
        box = deformed(f"box_lattice_{axis}", 0, f"-deform_{axis} rate -deform_{axis}_rate 1e-6 "
                       f"-deform_{axis}_until {strain} -ts_dt 10 -ts_max_steps 40 "
                       "-monitor_interval 40")["box"]
        if axis == "xy":
            rows.append(relative(FAMILY, "triangular lattice sheared along x across y: stress, GPa",
                                 LAME * strain, box["xy_GPa"][-1], 1e-3, "strain of 1e-4"))
            continue
        for along, share in ((axis, 3), ("yx"["xy".index(axis)], 1)):
            what = f"triangular lattice pulled along {axis}: stress along {along}, GPa"
            rows.append(relative(FAMILY, what, share * LAME * strain, box[2 * along + "_GPa"][-1],
                                 1e-3, "strain of 1e-4"))
    return rows


def standing(name: str, fibres: list[states.Fibre], size: Array,
             tilt: Array) -> tuple[Array, float]:
    """Forces on fibres in a periodic box whose images slide, and their energy."""
    folder = new_folder(name)
    state = states.of_fibres(fibres, [0, 0, 0], size, (1, 1, 1))
    state.tilt = tilt
    states.write(folder / "in.h5", state)
    simulate(name, "-scene file -scene_file {dir}/in.h5 -ts_max_steps 0 -start_unchecked "
             "-pair_allow_overlap -state_forces -state_output {dir}/out.h5 "
             "-energy_monitor ascii:{dir}/energy.csv")
    return (states.read(folder / "out.h5")["force"],
            float(tables.read(folder / "energy.csv")["total"][-1]))


def tilted() -> list[Row]:
    """A box whose images slide by half its length is half of a straight box of twice its height."""
    size, slide, rng = np.array([160.0, 170.0, 180.0]), np.array([80.0, 0, 0]), \
        np.random.default_rng(7)
    fibres = []
    for _ in range(40):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        turn = np.cross([1, 0, 0], axis)
        q = rotation_about(turn, np.full(4, math.acos(axis[0])))
        fibres.append((size * rng.uniform(size=3) + T * np.arange(4)[:, None] * axis, q))
    copy = [(x + [slide[0], size[1], 0], q) for x, q in fibres]
    force, energy = standing("box_tilted", fibres, size, slide)
    twice, both = standing("box_straight", fibres + copy, size * [1, 2, 1], np.zeros(3))
    wrong = float(np.abs(twice - np.tile(force, (2, 1))).max() / np.abs(force).max())
    return [relative(FAMILY, "tilted by half a period: energy of 40 fibres, over half of that of a "
                     "straight box of twice the size", 1.0, 2 * energy / both, 1e-12, "round-off"),
            Row(FAMILY, "the same: forces on all segments, over the largest", 0.0, wrong, wrong,
                1e-10, "round-off")]


DEFORMS = {"stretched": "-deform_x rate -deform_x_rate 1e-5 -deform_y free",
           "sheared": "-deform_xy rate -deform_xy_rate 1e-5"}


def missed(how: str, dt: float) -> float:
    """What the work of the box misses at most when a lattice out of order is stretched or sheared
    by 40 %, over that work."""
    energy = deformed(f"box_{how}_{dt:g}", 12, f"{DEFORMS[how]} -deform_interval 1 -ts_dt {dt} "
                      f"-ts_max_steps {round(4e4 / dt)} -monitor_interval {round(800 / dt)}"
                      )["energy"]
    return float(np.abs(energy["total"] - energy["external"]).max() / energy["external"][-1])


def balance() -> list[Row]:
    """Order in the step of what the work of the box misses."""
    rows = []
    for name in DEFORMS:
        found = order([missed(name, dt) for dt in (20, 10)])
        rows.append(Row(FAMILY, f"lattice out of order, {name} by 40 %: order of the balance", 2.0,
                        found, abs(found - 2), 0.2, "next order, at steps of 20 and 10 fs"))
    return rows


CHECKS = {"box_hooke": hooke, "box_lattice": lattice, "box_tilted": tilted, "box_balance": balance}
