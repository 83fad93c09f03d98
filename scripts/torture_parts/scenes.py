"""Small scenes, drawn at random, that between them use every part of the program."""

import pathlib
import random
from dataclasses import dataclass, field

from .processes import Command
from .trial import Setting, Trial


@dataclass
class Scene:
    """Options of a run without its outputs, and its last step."""
    kind: str
    options: list[str]
    steps: int
    tension: bool = False
    table_interval: int = 10
    snapshot_interval: int = 0
    checkpoint_interval: int = 0
    tables: list[str] = field(default_factory=list)

    def physics(self) -> list[str]:
        return [*self.options, "-progress_interval", "0"]

    def outputs(self) -> list[str]:
        """Options of every file that the run leaves."""
        words = ["-state_output", "out.h5", "-energy_monitor", "ascii:energy.csv",
                 "-monitor_interval", str(self.table_interval)]
        if self.tension:
            words += ["-stress_monitor", "ascii:stress.csv"]
        if self.snapshot_interval:
            words += ["-snapshot_file", "frame", "-snapshot_interval", str(self.snapshot_interval)]
        if self.checkpoint_interval:
            words += ["-checkpoint_file", "c.h5", "-checkpoint_interval",
                      str(self.checkpoint_interval)]
        return words

    def end(self, steps: int | None = None) -> list[str]:
        return ["-ts_max_steps", str(self.steps if steps is None else steps)]

    def all_options(self) -> list[str]:
        return self.physics() + self.outputs() + self.end()


def _number(rng: random.Random, low: float, high: float) -> str:
    return f"{rng.uniform(low, high):.4g}"


def _one_of(rng: random.Random, *groups: list[str]) -> list[str]:
    return rng.choice(groups)


def _weave(rng: random.Random) -> list[str]:
    return ["-weave_fibres", f"{rng.randint(2, 4)},{rng.randint(2, 4)}", "-weave_segments",
            str(rng.randint(12, 28)), "-scene_perturb", _number(rng, 0, 0.2)]


def _damped(rng: random.Random) -> list[str]:
    return _weave(rng) + ["-damping_local", _number(rng, 0, 0.7)]


def _periodic(rng: random.Random) -> list[str]:
    return ["-weave_fibres", "6,6", "-weave_segments", "36", "-weave_periodic", "-scene_perturb",
            _number(rng, 0, 0.3), *_one_of(rng, [], ["-pair_far_points", "1"],
                                          ["-pair_points", "5"])]


def _fibre(rng: random.Random) -> list[str]:
    return ["-scene", "fibre", "-fibre_segments", str(rng.randint(2, 60)), "-fibre_bend",
            _number(rng, 0, 1), "-fibre_twist", _number(rng, 0, 0.5), "-fibre_strain",
            _number(rng, 0, 0.008), *_one_of(rng, [], ["-pair", "none"])]


def _closed(rng: random.Random) -> list[str]:
    return ["-scene", "fibre", "-fibre_closed", "-fibre_bend", "6.283185307179586",
            "-fibre_segments", str(rng.randint(60, 90)), "-scene_perturb", _number(rng, 0, 0.05)]


def _viscous(rng: random.Random) -> list[str]:
    return _weave(rng) + ["-damping_viscous", _number(rng, 0.01, 20), "-damping_viscous_angular",
                          _number(rng, 0, 500)]


def _fire(rng: random.Random) -> list[str]:
    return _weave(rng) + ["-relax_method", "fire", "-relax_force", _number(rng, 0.01, 0.5),
                          "-ts_limit_interval", str(rng.choice([50, 100, 20000]))]


def _held(rng: random.Random) -> list[str]:
    edge = ["-bc", "edge,pull", "-edge_region", "-1000,-1000,-1000,20,1000,1000"]
    edge += rng.choice([["-edge_fix", "1,0,1"], ["-edge_fix", "1,1,1", "-edge_fix_rotation"],
                        ["-edge_velocity", "1e-5,0,0", "-edge_ramp", "2000"]])
    return _damped(rng) + edge + ["-pull_region", "100,-1000,-1000,1000,1000,1000", "-pull_force",
                                  "0.01,0,0", "-pull_ramp", _number(rng, 0, 4000)]


def _tension(rng: random.Random) -> list[str]:
    # Fast, so that bonds break within a few hundred steps.
    return ["-weave_fibres", "4,4", "-weave_segments", "32", "-damping_local", "0.4",
            "-tension_rate", _number(rng, 2e-5, 8e-5), "-tension_ramp", "500", "-tension_grip",
            "40", "-tension_max_strain", "0.4", "-break_strain_mean", _number(rng, 0.05, 0.12),
            "-break_strain_std", "0.02", "-break_seed", str(rng.randint(1, 99)), "-ts_dt", "10",
            *_one_of(rng, [], ["-damping_viscous", "5"], ["-break_per", "fibre"])]


def _single(rng: random.Random) -> list[str]:
    return _periodic(rng)[:7] + ["-pair_precision", "single"]


MAKERS = {"weave": _damped, "periodic": _periodic, "fibre": _fibre, "closed": _closed,
          "viscous": _viscous, "fire": _fire, "held": _held, "tension": _tension,
          "single": _single}
# Steps of a run that takes about a tenth of a second.
STEPS = {"weave": 200, "periodic": 60, "fibre": 500, "closed": 300, "viscous": 200, "fire": 200,
         "held": 200, "tension": 300, "single": 60}


def draw(rng: random.Random, kinds: list[str], length: float = 1.0) -> Scene:
    """A scene of one of the kinds with random outputs; `length` scales its steps."""
    kind = rng.choice(kinds)
    steps = max(10, int(STEPS[kind] * length * rng.uniform(0.7, 1.3)))
    scene = Scene(kind, MAKERS[kind](rng), steps, kind == "tension")
    scene.table_interval = rng.choice([1, 5, 10, 25])
    scene.snapshot_interval = rng.choice([0, steps // 2, steps // 4, steps // 7])
    scene.checkpoint_interval = max(1, steps // rng.choice([3, 8, 20]))
    return scene


def kinds_offered(setting: Setting) -> list[str]:
    """All kinds, without single precision where this build or machine does not have it."""
    with setting.lock:
        if setting.kinds is None:
            trial = Trial(setting, "references", 0, "single-offered")
            outcome = trial.run(Command(["-pair_precision", "single", "-weave_fibres", "2,2",
                                         "-weave_segments", "12", "-ts_max_steps", "0"]))
            trial.remove()
            setting.kinds = [kind for kind in MAKERS if kind != "single" or outcome.status == 0]
    return setting.kinds


def reference(setting: Setting, key: str, scene: Scene) -> pathlib.Path:
    """The folder of the run of this scene that nothing disturbs, on 1 rank x 1 thread."""
    def make(trial: Trial) -> None:
        trial.expect(trial.run(Command(scene.all_options())), 0)
    return setting.kept(key, make)
