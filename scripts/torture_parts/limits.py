"""Full disks, limits, missing and odd files, fewer threads: the true reason, soon."""

import os
import pathlib
import random
import shutil
import subprocess
import time
from collections.abc import Callable

from .files import first_difference, problem_of_state
from .processes import Command
from .scenes import Scene, draw, reference
from .trial import TIMEOUT, Trial

SCENES = 8
KINDS = ["weave", "fibre", "viscous", "held", "tension"]
OUTPUTS = {"-state_output": "out.h5", "-energy_monitor": "ascii:energy.csv",
           "-checkpoint_file": "c.h5", "-snapshot_file": "frame"}


def _scene(trial: Trial) -> tuple[Scene, pathlib.Path]:
    number = trial.random.randrange(SCENES)
    scene = draw(random.Random(f"{trial.setting.seed}/limits/{number}"), KINDS)
    return scene, reference(trial.setting, f"limits-{number}", scene)


def _judge(trial: Trial, scene: Scene, whole: pathlib.Path, command: Command) -> None:
    """Status 0 with the same results, or 1 or 2 with the reason; no state is left damaged."""
    outcome = trial.run(command)
    if not trial.expect(outcome, 0, 1, 2):
        return
    trial.note(f"status {outcome.status}: {' '.join(outcome.error_lines())[:300]}")
    if outcome.status == 0:
        _same(trial, whole)
    for path in sorted(trial.folder.glob("*.h5")):
        if path.is_file() and (problem := problem_of_state(path)):
            trial.fail(f"status {outcome.status}: {problem}")
    names = {path.name for path in whole.iterdir()} | {"c.h5", "out.h5"}
    for path in trial.folder.iterdir():
        frame = path.name.startswith("frame")
        if path.name not in names and not (frame and ".tmp" not in path.name):
            trial.fail(f"litter: {path.name}")


def _same(trial: Trial, whole: pathlib.Path) -> None:
    for path in sorted(whole.iterdir()):
        if (trial.folder / path.name).is_file():
            if problem := first_difference(trial.folder / path.name, path):
                trial.fail(f"status 0: {problem}")


def _replaced(options: list[str], name: str, value: str) -> list[str]:
    """The options with another value of one, added where it is not there."""
    if name not in options:
        return [*options, name, value]
    at = options.index(name)
    return [*options[:at + 1], value, *options[at + 2:]]


def _limited(trial: Trial, scene: Scene, whole: pathlib.Path, command: Command) -> None:
    size = trial.random.choice([0, trial.random.randint(1, 4096), trial.random.randint(1, 100000)])
    command.limits = [f"--fsize={size}"]
    _judge(trial, scene, whole, command)


def _memory(trial: Trial, scene: Scene, whole: pathlib.Path, command: Command) -> None:
    kind = trial.random.choice(["as", "data"])
    size = int(trial.random.uniform(2e7, 1.5e9 if kind == "as" else 3e8))
    command.limits = [f"--{kind}={size}"]
    command.ranks = 0
    # Below some size MPI and PETSc themselves cannot start, and say so in their own ways.
    asked = trial.run(Command(["-version"], limits=command.limits))
    if asked.status != 0:
        if trial.run(command).status in (0, None):
            trial.fail("-version fails for want of memory, a run does not or hangs")
        return
    outcome = trial.run(command)
    if outcome.status is None or outcome.status == 139:
        trial.fail(f"{command.limits}: {outcome.complaint(0, 1, 2)}")
    elif outcome.status == 0:
        _same(trial, whole)
    elif outcome.complaint(1, 2):
        trial.fail(f"{command.limits}: {outcome.complaint(1, 2)}")


def _full_disk(trial: Trial, scene: Scene, whole: pathlib.Path, command: Command) -> None:
    size = trial.random.choice([4, 16, 40, 64, 100, 200, 400])
    if not _mount(trial, f"size={size}k"):
        return
    try:
        if trial.random.random() < 0.5:  # an older checkpoint stands there already
            trial.run(Command(scene.physics() + scene.outputs() + scene.end(2)))
            command.options += ["-restart", "c.h5"] if (trial.folder / "c.h5").exists() else []
        _judge(trial, scene, whole, command)
    finally:
        _unmount(trial)


def _read_only(trial: Trial, scene: Scene, whole: pathlib.Path, command: Command) -> None:
    if not _mount(trial, "ro"):
        return
    try:
        _judge(trial, scene, whole, command)
    finally:
        _unmount(trial)


def _mount(trial: Trial, options: str) -> bool:
    words = ["mount", "-t", "tmpfs", "-o", options, "none", str(trial.folder)]
    trial.note(" ".join(words))
    mounted = subprocess.run(words, capture_output=True, check=False).returncode == 0
    trial.counts["limits, no mount allowed"] += not mounted
    return mounted


def _unmount(trial: Trial) -> None:
    kept = pathlib.Path(f"{trial.folder}.kept")
    shutil.copytree(trial.folder, kept, symlinks=True)
    subprocess.run(["umount", "-l", str(trial.folder)], check=True)
    shutil.copytree(kept, trial.folder, symlinks=True, dirs_exist_ok=True)
    shutil.rmtree(kept)


def _odd_path(trial: Trial) -> str:
    """A path that nothing can be written to, or that only looks odd."""
    rng, folder = trial.random, trial.folder
    kind = rng.choice(["missing", "long", "deep", "fifo", "full", "null", "dangling", "folder",
                       "file", "empty", "spaces"])
    trial.note(f"path: {kind}")
    if kind == "missing":
        return "not/there/x.h5"
    if kind in ("long", "spaces"):
        return "n" * rng.randint(240, 300) if kind == "long" else rng.choice(["a b", "a'b", "ä#b"])
    if kind == "deep":
        return "/".join(["d" * 100] * rng.choice([3, 45])) + "/x.h5"
    if kind == "fifo":
        os.mkfifo(folder / "pipe")
        return "pipe"
    if kind == "dangling":
        (folder / "link").symlink_to("nowhere/else")
        return "link"
    if kind == "folder":
        (folder / "sub").mkdir()
        return "sub"
    if kind == "file":
        (folder / "letter.txt").write_text("my only copy\n")
        return "letter.txt"
    return {"full": "/dev/full", "null": "/dev/null", "empty": ""}[kind]


def _odd_output(trial: Trial, scene: Scene, whole: pathlib.Path, command: Command) -> None:
    option = trial.random.choice(list(OUTPUTS))
    path = _odd_path(trial)
    value = f"ascii:{path}" if option == "-energy_monitor" else path
    command.options = _replaced(command.options, option, value)
    outcome = trial.run(command)
    trial.expect(outcome, 0, 1, 2)
    trial.note(f"status {outcome.status}: {' '.join(outcome.error_lines())[:300]}")
    letter = trial.folder / "letter.txt"
    if letter.exists() and letter.read_text() != "my only copy\n":
        trial.fail(f"{option} replaced a foreign file")
    if (trial.folder / "link").exists() or (path == "link"
                                            and not (trial.folder / "link").is_symlink()):
        trial.fail(f"{option} replaced a link that dangles")
    if pathlib.Path("/dev/full").is_file() or pathlib.Path("/dev/null").is_file():
        trial.fail(f"{option} replaced a device")


def _odd_input(trial: Trial, scene: Scene, whole: pathlib.Path, command: Command) -> None:
    path = _odd_path(trial)
    # A program waits for who writes into a pipe.
    options_file = "/dev/null" if path == "pipe" else path
    command.options = trial.random.choice([
        ["-scene", "file", "-scene_file", path, "-ts_max_steps", "1"],
        [*scene.physics(), *scene.end(), "-restart", path],
        [*scene.physics(), *scene.end(), "-options_file", options_file]])
    # Nothing in an options file is what /dev/null and a folder's listing have.
    trial.expect(trial.run(command), *((0, 1) if "-options_file" in command.options else (1,)))


def _removed_folder(trial: Trial, scene: Scene, whole: pathlib.Path, command: Command) -> None:
    running = trial.start(command)
    time.sleep(trial.random.uniform(0, 0.8))
    shutil.rmtree(trial.folder, ignore_errors=True)
    trial.note("the folder is removed")
    outcome = running.wait(TIMEOUT)
    # mpirun itself needs the folder at its start, and may be told not to say so.
    silent = not outcome.output and not outcome.errors
    if not silent and "working directory" not in outcome.errors:
        trial.expect(outcome, 0, 1, 2)
    trial.folder.mkdir(parents=True, exist_ok=True)


def _fewer_threads(trial: Trial, scene: Scene, whole: pathlib.Path, command: Command) -> None:
    command.threads = trial.random.randint(2, 8)
    command.variables = trial.random.choice([
        {"OMP_THREAD_LIMIT": str(trial.random.randint(1, 4))}, {"OMP_MAX_ACTIVE_LEVELS": "0"},
        {"OMP_DYNAMIC": "true"}, {"OMP_NUM_THREADS": trial.random.choice(["0", "-1", "x", "2,3"])}])
    outcome = trial.run(command)
    if trial.expect(outcome, 0, 1) and outcome.status == 0:
        _same(trial, whole)


KINDS_OF_LIMIT: list[Callable[[Trial, Scene, pathlib.Path, Command], None]] = [
    _limited, _memory, _full_disk, _full_disk, _read_only, _odd_output, _odd_output, _odd_input,
    _removed_folder, _fewer_threads]


def limit_trial(trial: Trial) -> None:
    scene, whole = _scene(trial)
    kind = trial.random.choice(KINDS_OF_LIMIT)
    command = Command(scene.all_options(), trial.random.choice([0, 0, 0, 2]))
    kind(trial, scene, whole, command)
    trial.counts["limits"] += 1
    if trial.failures:
        trial.failures[0] = f"{kind.__name__[1:]}: {trial.failures[0]}"
