"""What the parts of the model cost, and what a scene loses without them."""

from .. import tables
from .axes import rms
from .independent import EJ, LENGTH
from .settings import DEFAULT

# A scene that never asked for anything but bonds, pairs and motion.
BARE = dict(DEFAULT, damping_local=False)
TENSION = {"scene": "weave", "weave_fibres": "6,6", "weave_segments": 90, "damping_local": 0.4,
           "tension_axis": "x", "tension_rate": 2e-6, "tension_max_strain": 0.05}
STRETCH, SHEAR, TORSION = 67.593, 12 * EJ / LENGTH, 1470.6


def stiffness(shear=1.0, torsion=1.0):
    """B1..B4 with part of the shear or torsional stiffness;
    the curvature's stiffness EJ/T stays."""
    b2, b4 = shear * SHEAR, torsion * TORSION
    return f"{STRETCH!r},{b2!r},{EJ / LENGTH - b2 / 4 - b4 / 2!r},{b4!r}"


def cases(folder):
    """Name -> options beside BARE. Those named `off` set an option to its neutral value."""
    viscous = {"damping_viscous": 0.01, "damping_viscous_angular": 1.0}
    monitor = {"energy_monitor": f"ascii:{folder / 'monitored.csv'}"}
    return {
        "bare (noise of the measurement)": {},
        "local damping off": {"damping_local": 0},
        "viscous damping off": dict.fromkeys(viscous, 0),
        "without pair forces": {"pair": "none"} | dict.fromkeys([k for k in DEFAULT], False),
        "with local damping": {"damping_local": 0.4},
        "with viscous damping": viscous,
        "with breakage": {"break_strain_mean": 0.3},
        "with energies every step": dict(monitor, monitor_interval=1),
        "with energies every 10 steps": dict(monitor, monitor_interval=10),
        "with energies every 100 steps": dict(monitor, monitor_interval=100),
        "without torsional stiffness (a millionth)": {
            "fibre_bond_stiffness": stiffness(torsion=1e-6)},
        "a quarter of the shear stiffness": {"fibre_bond_stiffness": stiffness(shear=0.25)},
    }


def costs(stopwatch, scene, folder):
    made = {name: BARE | more for name, more in cases(folder).items()}
    return stopwatch.costs(scene, made, BARE, paired=True)


def events(stopwatch, scene, folder):
    """The solver's log events in 100 steps of a bare scene, without pair forces, and with all."""
    more = cases(folder)
    everything = (BARE | more["with viscous damping"] | more["with breakage"]
                  | more["with energies every step"] | {"damping_local": 0.4})
    runs = {"bare": BARE, "without pair forces": BARE | more["without pair forces"],
            "everything": everything}
    return {name: stopwatch.once(scene, options, 100, "-log_view").events
            for name, options in runs.items()}


def errors(program, folder):
    """(case, scene, measure, error) of leaving a part out where it does not matter much."""
    found = []
    weave = {"scene": "weave", "weave_fibres": "8,8", "weave_segments": 40, "weave_periodic": None,
             "scene_perturb": 0.05, "damping_local": 0.4, "ts_max_time": 12000}
    full, printed = program.final(weave)
    for case, less in (("without torsional stiffness (a millionth)", stiffness(torsion=1e-6)),
                       ("a quarter of the shear stiffness", stiffness(shear=0.25))):
        state, other = program.final(dict(weave, fibre_bond_stiffness=less))
        found.append((case, "weave at rest", "elastic energy", other.elastic / printed.elastic - 1))
        found.append((case, "weave at rest", "position, A", rms(state.whole - full.whole)))

    def stress(more):
        file = folder / "stress.csv"
        program.run(TENSION | more | {"stress_monitor": f"ascii:{file}"})
        rows = tables.read(file)
        return 0.5 * (rows["stress_left_GPa"][-1] + rows["stress_right_GPa"][-1])
    full = stress({})
    for case, more in (("without pair forces", {"pair": "none"}),
                       ("with breakage", {"break_strain_mean": 0.3})):
        with_or_without = stress(more)
        found.append((case, "sparse tension", "stress at 5 %", with_or_without / full - 1))
    return [(case, scene, measure, abs(float(error))) for case, scene, measure, error in found]
