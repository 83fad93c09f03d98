"""Ranks, threads, partitions, restarts and skins drawn at random: the bytes must be the same."""

import random

from .files import first_difference
from .processes import Command
from .scenes import Scene, draw, kinds_offered, reference
from .trial import Trial

PER_SCENE = 6  # layouts compared with each undisturbed run


def _pieces(scene: Scene, rng: random.Random) -> list[int]:
    """Steps at which the run is broken off and taken up by a restart."""
    count = rng.choice([0, 0, 1, 1, 2])
    return sorted(rng.sample(range(1, scene.steps), count)) if scene.steps > 2 else []


def layout_trial(trial: Trial) -> None:
    number = trial.number // PER_SCENE
    drawn = random.Random(f"{trial.setting.seed}/bytes/{number}")
    scene = draw(drawn, kinds_offered(trial.setting))
    whole = reference(trial.setting, f"bytes-{number}", scene)
    rng = trial.random
    restart: list[str] = []
    skin = ["-pair_skin", f"{rng.uniform(0.5, 20):.3g}"] if rng.random() < 0.4 else []
    if "none" in scene.options:
        skin = []
    for steps in [*_pieces(scene, rng), scene.steps]:
        layout = ["-partition", rng.choice(["dmda", "metis", "auto"]), *skin]
        if layout[1] != "dmda" and rng.random() < 0.3:
            layout += ["-partition_piece", str(rng.choice([2, 8, 100]))]
        options = scene.physics() + scene.outputs() + scene.end(steps) + layout + restart
        command = Command(options, rng.choice([0, 1, 2, 2, 3, 4]), rng.randint(1, 3))
        if rng.random() < 0.2:
            command.variables = rng.choice([{"OMP_THREAD_LIMIT": "1"}, {"OMP_THREAD_LIMIT": "2"},
                                            {"OMP_MAX_ACTIVE_LEVELS": "0"},
                                            {"OMP_DYNAMIC": "true"}])
        if not trial.expect(trial.run(command), 0):
            return
        restart = ["-restart", "c.h5"]
    trial.counts["comparisons"] += 1
    for path in sorted(whole.iterdir()):
        # The last piece writes a state at its own end, too.
        if path.name != "c.h5" and (problem := first_difference(trial.folder / path.name, path)):
            trial.fail(problem)
