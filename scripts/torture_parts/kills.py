"""Runs killed or signalled at random instants, checked, and brought to their end by restarts."""

import pathlib
import random
import re
import signal
import time

from .files import first_difference, problem_of_state, problem_of_table, step_of_state
from .processes import Command, Running, send
from .scenes import Scene, draw, kinds_offered, reference
from .trial import TIMEOUT, Trial

SCENES = 24  # scenes of a campaign's kills; each has its undisturbed run
SIGNALS = [signal.SIGINT, signal.SIGHUP, signal.SIGTERM, signal.SIGUSR1, signal.SIGXCPU]


def _scene(trial: Trial) -> tuple[Scene, pathlib.Path]:
    number = trial.random.randrange(SCENES)
    scene = draw(random.Random(f"{trial.setting.seed}/kills/{number}"),
                 kinds_offered(trial.setting), 4.0)
    return scene, reference(trial.setting, f"kills-{number}", scene)


def _layout(rng: random.Random) -> tuple[int, int, list[str]]:
    ranks, threads = rng.choice([0, 0, 0, 1, 2, 2, 3]), rng.choice([1, 1, 2])
    return ranks, threads, ["-partition", rng.choice(["dmda", "metis", "auto"])]


def _shape(folder: pathlib.Path) -> tuple[tuple[str, int, int], ...]:
    found = []
    for path in folder.iterdir():
        try:
            status = path.stat()
            found.append((path.name, status.st_mtime_ns, status.st_size))
        except FileNotFoundError:
            pass
    return tuple(sorted(found))


def _wait_for_changes(running: Running, folder: pathlib.Path, count: int) -> None:
    """Returns when files of the folder have changed that often, or the run is over."""
    shape, seen, end = _shape(folder), 0, time.monotonic() + TIMEOUT
    while seen < count and not running.over() and time.monotonic() < end:
        time.sleep(0.0005)
        now = _shape(folder)
        seen, shape = seen + (now != shape), now


def _wait_for_header(running: Running) -> None:
    end = time.monotonic() + TIMEOUT
    out = running.prints / "out.txt"
    while not running.over() and time.monotonic() < end and out.stat().st_size == 0:
        time.sleep(0.002)


def _random_instant(trial: Trial, running: Running, scene: Scene) -> str:
    """Waits until some instant: after a random time, or after a random number of writes."""
    rng = trial.random
    writes = scene.steps // scene.checkpoint_interval
    if scene.snapshot_interval:
        writes += scene.steps // scene.snapshot_interval
    if rng.random() < 0.3:
        seconds = rng.uniform(0, 1.5)
        time.sleep(seconds)
        return f"after {seconds:.3f} s"
    count, seconds = rng.randint(1, writes), rng.choice([0, rng.uniform(0, 0.02)])
    _wait_for_changes(running, trial.folder, count)
    time.sleep(seconds)
    return f"{1e3 * seconds:.1f} ms after {count} changes in the folder"


def _known(scene: Scene, name: str) -> bool:
    pattern = r"c\.h5|out\.h5|energy\.csv|stress\.csv|frame\.xdmf|frame_\d{10}\.h5"
    return re.fullmatch(pattern, name) is not None


def _is_between_names(path: pathlib.Path) -> bool:
    """A kill between a file's last two steps, name and new name, leaves it whole by the first."""
    return re.fullmatch(r".+\.(h5|xdmf)\.tmp-\w{6}", path.name) is not None


def _check_files(trial: Trial, scene: Scene, when: str) -> None:
    """Every state whole, every table without a hole up to the last checkpoint, no litter."""
    for path in sorted(trial.folder.iterdir()):
        if not _is_between_names(path) and not _known(scene, path.name):
            trial.fail(f"litter {when}: {path.name}")
        elif ".h5" in path.suffixes and (problem := problem_of_state(path)):
            trial.fail(f"{when}: {problem}")
    checkpoint = trial.folder / "c.h5"
    if not checkpoint.exists() or trial.failures:
        return
    through = step_of_state(checkpoint)
    for name in ["energy.csv"] + ["stress.csv"] * scene.tension:
        path = trial.folder / name
        if not path.exists():
            trial.fail(f"{when}: {name} is missing, the checkpoint is of step {through}")
        elif problem := problem_of_table(path, scene.table_interval, through):
            trial.fail(f"{when}: {problem} (checkpoint of step {through})")


def _compare(trial: Trial, whole: pathlib.Path) -> None:
    for path in sorted(whole.iterdir()):
        if problem := first_difference(trial.folder / path.name, path):
            trial.fail(f"after the restarts: {problem}")
    for path in sorted(trial.folder.iterdir()):
        if not (whole / path.name).exists() and not _is_between_names(path):
            trial.fail(f"after the restarts: {path.name} is too much")


def _command(trial: Trial, scene: Scene) -> Command:
    """Start, or restart where there is a checkpoint, in a layout of its own."""
    ranks, threads, partition = _layout(trial.random)
    restart = ["-restart", "c.h5"] if (trial.folder / "c.h5").exists() else []
    return Command(scene.all_options() + partition + restart, ranks, threads)


def _finish(trial: Trial, scene: Scene, whole: pathlib.Path) -> None:
    if trial.failures:
        return
    if trial.expect(trial.run(_command(trial, scene)), 0):
        _check_files(trial, scene, "at the end")
        _compare(trial, whole)


def kill_trial(trial: Trial) -> None:
    """kill -9 once to three times; then to the end."""
    scene, whole = _scene(trial)
    for _ in range(trial.random.choice([1, 1, 2, 3])):
        running = trial.start(_command(trial, scene))
        instant = _random_instant(trial, running, scene)
        ranks = running.ranks()
        if ranks and running.ranks_asked and trial.random.random() < 0.3:
            victim = trial.random.choice(ranks)
            send(victim, signal.SIGKILL)
            trial.note(f"kill -9 of one rank {instant}")
            status = running.wait(TIMEOUT).status
        else:
            over = running.over()
            running.kill()
            trial.note(f"kill -9 of all {instant}")
            status = running.process.returncode if over else 137
        if status is None:
            trial.fail("the ranks left over after one was killed hang")
        elif status != 0:
            trial.counts["kills"] += 1
            _check_files(trial, scene, "after the kill")
        if trial.failures:
            return
    _finish(trial, scene, whole)


def signal_trial(trial: Trial) -> None:
    """A polite signal leaves a checkpoint and status 3; then to the end."""
    scene, whole = _scene(trial)
    for _ in range(trial.random.choice([1, 2])):
        running = trial.start(_command(trial, scene))
        number = trial.random.choice(SIGNALS)
        _wait_for_header(running)
        instant = _random_instant(trial, running, scene)
        # mpirun passes SIGUSR1 on and answers others by killing the ranks.
        ranks = running.ranks()
        if not ranks or running.over():
            target = None
        elif running.ranks_asked and number == signal.SIGUSR1 and trial.random.random() < 0.5:
            target = running.process.pid
        else:
            target = trial.random.choice(ranks)
        if target:
            send(target, number)
        trial.note(f"{signal.Signals(number).name} {instant}")
        outcome = running.wait(TIMEOUT)
        if not trial.expect(outcome, 0, 3):
            return
        if outcome.status == 3:
            trial.counts["signals"] += 1
            if not (trial.folder / "c.h5").exists():
                trial.fail("status 3 without a checkpoint")
            _check_files(trial, scene, "after the signal")
        if trial.failures:
            return
    _finish(trial, scene, whole)
