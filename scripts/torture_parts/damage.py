"""Damaged files: states with flipped, zeroed or missing bytes, tables with torn or doubled rows.

The program must refuse them with one line and status 1, or the damage must have no effect."""

import pathlib
import random
import re
import shutil
from collections.abc import Callable

from .files import first_difference
from .processes import Command
from .scenes import Scene, draw
from .trial import Setting, Trial

SCENES = 6
KINDS = ["weave", "fibre", "closed", "viscous", "fire", "held", "tension"]


def _outputs(scene: Scene) -> list[str]:
    words = ["-state_output", "out.h5", "-state_forces", "-energy_monitor", "ascii:energy.csv",
             "-monitor_interval", "5"]
    return words + ["-stress_monitor", "ascii:stress.csv"] * scene.tension


def _start_options(scene: Scene, source: str) -> list[str]:
    """The options of a run that starts from the file x.h5, and of what it then does."""
    if source == "c.h5":
        return [*scene.physics(), *_outputs(scene), "-restart", "x.h5",
                *scene.end(scene.steps + 12)]
    # Boundary conditions and tension go with the scene; what makes the geometry does not.
    return ["-scene", "file", "-scene_file", "x.h5", "-progress_interval", "0", *_outputs(scene),
            *scene.end(6)]


SOURCES = ["c.h5", "c.h5", "out.h5", "frame_0000000000.h5"]


def _bases(setting: Setting, number: int) -> tuple[Scene, pathlib.Path]:
    """A scene and the folder with its files and what undamaged ones lead to (SOURCE.want)."""
    scene = draw(random.Random(f"{setting.seed}/flips/{number}"), KINDS, 0.3)

    def make(trial: Trial) -> None:
        first = [*scene.physics(), *_outputs(scene), "-checkpoint_file", "c.h5", "-snapshot_file",
                 "frame", "-snapshot_interval", "1000000", *scene.end()]
        trial.expect(trial.run(Command(first)), 0)
        for name in SOURCES:
            scratch = Trial(setting, "references", 0, f"flips-{number}-{name}")
            shutil.copy(trial.folder / name, scratch.folder / "x.h5")
            if name == "c.h5":
                _copy_tables(trial.folder, scratch.folder)
            scene.tension = scene.tension and name == "c.h5"
            trial.expect(scratch.run(Command(_start_options(scene, name))), 0)
            shutil.copytree(scratch.folder, trial.folder / f"{name}.want", dirs_exist_ok=True)
            scratch.remove()

    tension = scene.tension
    folder = setting.kept(f"flips-{number}", make)
    scene.tension = tension
    return scene, folder


def _copy_tables(source: pathlib.Path, target: pathlib.Path) -> None:
    for path in source.glob("*.csv"):
        shutil.copy(path, target)


def _flip(data: bytearray, rng: random.Random) -> str:
    place = rng.randrange(len(data))
    if rng.random() < 0.3:  # superblock, headers and attributes stand at the file's beginning
        place = rng.randrange(min(len(data), 4096))
    before, data[place] = data[place], data[place] ^ rng.choice([1 << rng.randrange(8),
                                                                 rng.randrange(1, 256)])
    return f"byte {place}: {before} became {data[place]}"


def _fill(data: bytearray, rng: random.Random) -> str:
    place, length = rng.randrange(len(data)), rng.choice([2, 8, 64, 512, 4096])
    value = rng.choice([0, 0, 255])
    end = min(len(data), place + length)
    data[place:end] = bytes([value]) * (end - place)
    return f"bytes {place} to {end - 1} became {value}"


def _cut(data: bytearray, rng: random.Random) -> str:
    length = rng.choice([0, rng.randrange(len(data)), len(data) - rng.randint(1, 8)])
    del data[length:]
    return f"cut to {length} bytes"


def _append(data: bytearray, rng: random.Random) -> str:
    data += rng.randbytes(rng.randint(1, 600))
    return f"lengthened to {len(data)} bytes"


def _swap(data: bytearray, rng: random.Random) -> str:
    length = rng.choice([8, 64, 512])
    a, b = sorted(rng.sample(range(0, len(data) - length), 2))
    data[a:a + length], data[b:b + length] = data[b:b + length], data[a:a + length]
    return f"{length} bytes at {a} and {b} swapped"


def _damaged_state(trial: Trial, damage: Callable[[bytearray, random.Random], str],
                   count: str) -> None:
    rng = trial.random
    scene, base = _bases(trial.setting, rng.randrange(SCENES))
    source = rng.choice(SOURCES)
    scene.tension = scene.tension and source == "c.h5"
    data = bytearray((base / source).read_bytes())
    what = damage(data, rng)
    while data == (base / source).read_bytes():  # zeros became zeros
        what = damage(data, rng)
    trial.note(f"x.h5 is {source} with: {what}")
    (trial.folder / "x.h5").write_bytes(data)
    if source == "c.h5":
        _copy_tables(base, trial.folder)
    ranks = rng.choice([0] * 8 + [2])
    outcome = trial.run(Command(_start_options(scene, source), ranks))
    trial.counts[count] += 1
    if not trial.expect(outcome, 0, 1):
        trial.failures[-1] += f" ({source}: {what})"
        return
    trial.counts[f"{count}, " + ("harmless" if outcome.status == 0 else "refused")] += 1
    if outcome.status == 0:
        for name in ["out.h5", "energy.csv"]:
            if problem := first_difference(trial.folder / name, base / f"{source}.want" / name):
                trial.fail(f"accepted, and another result: {problem} ({source}: {what})")


def flip_trial(trial: Trial) -> None:
    _damaged_state(trial, _flip, "flips")


def damage_trial(trial: Trial) -> None:
    _damaged_state(trial, trial.random.choice([_fill, _cut, _append, _swap]), "other damage")


def _lines(text: bytes) -> tuple[int, list[bytes]]:
    """The lines, and the number of the first row of numbers."""
    lines = text.splitlines(keepends=True)
    first = next(k for k, line in enumerate(lines) if line[:1].isdigit())
    return first, lines


def _damage_table(text: bytes, rng: random.Random) -> tuple[str, bytes]:
    first, lines = _lines(text)
    row = rng.randrange(first, len(lines))
    kind = rng.choice(["flip", "torn", "doubled", "dropped", "garbage", "empty", "crlf", "head",
                       "swapped", "blank", "absent", "column"])
    if kind == "flip":
        data = bytearray(text)
        what = _flip(data, rng)
        return what, bytes(data)
    if kind == "torn":
        cut = rng.randrange(1, len(lines[row]))
        return f"row {row} torn", b"".join(lines[:row]) + lines[row][:cut]
    if kind == "doubled":
        lines.insert(rng.randrange(row, len(lines)) + 1, lines[row])
    elif kind == "dropped":
        del lines[row]
    elif kind == "garbage":
        lines.append(rng.randbytes(rng.randint(1, 100)))
    elif kind == "empty":
        lines = []
    elif kind == "crlf":
        lines = [line.replace(b"\n", b"\r\n") for line in lines]
    elif kind == "head":
        lines[first - 1] = rng.choice([b"", lines[first - 1].upper(), b"step,time_fs\n"])
    elif kind == "swapped":
        other = rng.randrange(first, len(lines))
        lines[row], lines[other] = lines[other], lines[row]
    elif kind == "blank":
        lines.insert(row, rng.choice([b"\n", b" \n", b"\n\n"]))
    elif kind == "column":
        lines[row] = rng.choice([lines[row].rpartition(b",")[0] + b"\n", b"1," + lines[row]])
    return f"{kind} at row {row}", b"".join(lines)


def _only_a_number_changed(damaged: bytes, result: bytes, want: bytes) -> bool:
    """Whether the result has one cell that another number was written into: nobody can know."""
    if result.count(b"\n") != want.count(b"\n") or len(result) != len(want):
        return False
    places = [k for k, (a, b) in enumerate(zip(result, want)) if a != b]
    if len(places) != 1 or damaged[places[0]:places[0] + 1] != result[places[0]:places[0] + 1]:
        return False
    start = result.rfind(b"\n", 0, places[0]) + 1
    line = result[start:result.find(b"\n", places[0])]
    number = rb"-?\d+(\.\d*)?(e[-+]?\d+)?"
    in_first_cell = places[0] - start <= line.find(b",")
    return not in_first_cell and all(re.fullmatch(number, cell) for cell in line.split(b","))


def table_trial(trial: Trial) -> None:
    """A restart whose table was damaged: the same table, or a line that names it."""
    rng = trial.random
    scene, base = _bases(trial.setting, rng.randrange(SCENES))
    shutil.copy(base / "c.h5", trial.folder / "x.h5")
    _copy_tables(base, trial.folder)
    name = rng.choice(["energy.csv"] + ["stress.csv"] * scene.tension)
    table = trial.folder / name
    what, damaged = _damage_table(table.read_bytes(), rng)
    trial.note(f"{name}: {what}")
    table.write_bytes(damaged)
    if what.startswith("absent"):
        table.unlink()
    outcome = trial.run(Command(_start_options(scene, "c.h5"), rng.choice([0, 0, 0, 2])))
    trial.counts["tables"] += 1
    if not trial.expect(outcome, 0, 1):
        trial.failures[-1] += f" ({name}: {what})"
    elif outcome.status == 1:
        trial.counts["tables, refused"] += 1
        if name not in outcome.error_lines()[0]:
            trial.fail(f"the line does not name {name}: {outcome.error_lines()[0][:200]}")
        if table.exists() and table.read_bytes() != damaged:
            trial.fail(f"{name} was refused, yet changed ({what})")
    else:
        want = (base / "c.h5.want" / name).read_bytes()
        if what.startswith(("absent", "empty")):
            # A table of the restart alone, and the user is told.
            if f"no earlier rows of this run in {name}" not in outcome.output + outcome.errors:
                trial.fail(f"{name} was {what.split()[0]}, and nobody is told")
        elif table.read_bytes() != want and not _only_a_number_changed(
                damaged, table.read_bytes(), want):
            trial.fail(f"accepted, and another table ({name}: {what})")
