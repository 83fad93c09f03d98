"""Sets of options drawn at random, right and wrong, on the command line and in odd files."""

import functools
import math
import os
import random
import re
import subprocess
from dataclasses import dataclass

import h5py
import numpy as np

from .files import first_difference, rows_of_table
from .processes import Command
from .trial import Trial

BASES = [
    ["-weave_fibres 2,2", "-weave_segments 12"],
    ["-weave_fibres 2,3", "-weave_segments 14", "-damping_local 0.3"],
    ["-scene fibre", "-fibre_segments 12", "-fibre_bend 0.3"],
    ["-weave_fibres 2,2", "-weave_segments 12", "-bc a,b", "-a_region -99,-99,-99,20,999,999",
     "-a_fix 1,1,1", "-b_region 100,-99,-99,999,999,999", "-b_force 0,0,0.001"],
    ["-weave_fibres 2,2", "-weave_segments 16", "-tension_rate 1e-6", "-tension_grip 30"],
    ["-weave_fibres 2,2", "-weave_segments 12", "-relax_method fire"],
    ["-units si", "-scene fibre", "-fibre_preset carbon_t300", "-fibre_segments 10"],
    ["-weave_fibres 6,6", "-weave_segments 36", "-weave_periodic"],
    ["-weave_fibres 2,2", "-weave_segments 12", "-break_strain_mean 0.1"],
]
WRONG = ["nan", "abc", "1e", "--", "1.0.0", "5 fs", "1;2", "%d", "0x", "1e5000", "NaN", "\u221e",
         "1,", ",1", "1,,2", "a" * 3000]
EXTREME = ["0", "-1", "1e-300", "1e300", "-1e300", "1e18", "2147483648", "-2147483649",
           "9223372036854775808", "1e-9", "0.5", "-0.0", "1e9", "+3", ".5", "7."]
FLAGS = ["", "true", "false", "1", "0", "yes", "no", "on", "off", "TRUE"]
# Their sizes are kept small, since a large run is no fault.
SIZES = {"weave_segments", "weave_fibres", "fibre_segments", "ts_max_steps", "pair_points",
         "pair_far_points"}
# They change neither the end nor the results, and may end or lengthen a run by themselves.
LEFT_OUT = {"ts_max_steps", "wall_time", "progress_interval", "restart", "scene_file", "help",
            "version", "options_file", "energy_monitor", "state_output", "stress_monitor",
            "checkpoint_file", "snapshot_file"}


USED_BY_ALL = ("fibre_[wyr]|pair(?!_far)|vdw|damping_v|ts_|seed|partition(?!_p)|energy|"
               "scene_perturb|domain_[lu]|state_f")


@dataclass
class Option:
    """An option as -help lists it."""
    name: str
    default: str
    choices: list[str]

    def flag(self) -> bool:
        return self.default in ("true", "false")

    def numeric(self) -> bool:
        text = not self.choices and not self.flag()
        return text and self.name not in ("bc", "kinds", "pair", "walls")


@functools.lru_cache
def known_options(binary: str) -> list[Option]:
    text = subprocess.run([binary, "-help"], capture_output=True, text=True, check=False,
                          timeout=120).stdout
    found: dict[str, Option] = {}
    for line in text.splitlines():
        match = re.match(r"  -(\w+) <(?!now )(.*?)>(?: \[.*?\])?: (.*)", line)
        if match:
            choices = re.search(r"\((\w+(?:\|\w+)+)\)$", match[3])
            found[match[1]] = Option(match[1], match[2], choices[1].split("|") if choices else [])
    return [option for option in found.values() if option.name not in LEFT_OUT]


@dataclass
class Word:
    """An option with its value; `wrong` when the program has to refuse it."""
    name: str
    value: str
    wrong: bool = False


def _number(option: Option, rng: random.Random) -> tuple[str, bool]:
    if rng.random() < 0.07:
        return rng.choice(WRONG), True
    first = re.match(r"-?[\d.]+(?:e-?\d+)?", option.default)
    usual = float(first[0]) if first else rng.choice([1.0, 10.0, 100.0])
    if rng.random() < 0.12:
        return rng.choice(EXTREME), False
    value = usual * rng.choice([0.5, 0.8, 0.9, 1.0, 1.1, 1.2, 2.0, rng.choice([0.0, 0.1, -1.0])])
    whole = "." not in option.default and rng.random() < 0.8
    return str(round(value)) if whole else f"{value:.6g}", False


def _value(option: Option, rng: random.Random) -> tuple[str, bool]:
    if option.flag():
        wrong = rng.random() < 0.1
        return (rng.choice(["maybe", "2", "tru", "-"]) if wrong else rng.choice(FLAGS)), wrong
    if option.choices:
        wrong = rng.random() < 0.1
        return rng.choice(["other", "", option.choices[0] + "x"] if wrong
                          else option.choices), wrong
    if option.name in ("bc", "kinds", "pair", "walls"):
        return rng.choice(["a", "a,b", "a,a", "", ",", "a b", "1", "x" * 300]), False
    lists = re.fullmatch(r"[-\d.e]+(,[-\d.e]+)*", option.default)
    parts = option.default.count(",") + 1 if lists else 1
    if option.name.endswith("_region"):
        parts = 6
    elif re.search("_ends|lower|upper|periodic", option.name):
        parts = {"tension_ends": 2}.get(option.name, 3)
    if rng.random() < 0.05:
        parts += rng.choice([-1, 1])
    numbers = [_number(option, rng) for _ in range(max(1, parts))]
    return ",".join(text for text, _ in numbers), any(wrong for _, wrong in numbers)


def _misspelt(name: str, rng: random.Random) -> str:
    place = rng.randrange(len(name))
    return rng.choice([name[:place] + name[place + 1:], name[:place] + "x" + name[place:],
                       name + "s", name.replace("_", "-") + "_", name[::-1]])


def _draw_word(options: list[Option], names: list[str], rng: random.Random) -> Word:
    # Half of the sets would be refused for an option that the scene has no use for.
    useful = [option for option in options if re.match(USED_BY_ALL, option.name)]
    option = rng.choice(useful if rng.random() < 0.7 else options)
    name = option.name.replace("NAME", rng.choice(names), 1)
    value, wrong = _value(option, rng)
    if option.name in SIZES and not wrong and "e" not in value:
        # Larger than this, but not so large that it must be refused, only takes long.
        value = ",".join(text if len(text) < 4 or float(text) > 1e9 else "30"
                         for text in value.split(","))
    if rng.random() < 0.06:
        return Word(_misspelt(name, rng), value, True)
    return Word(name, value, wrong)


def draw_set(options: list[Option], rng: random.Random) -> list[Word]:
    base = [line.partition(" ") for line in rng.choice(BASES)]
    words = [Word(name[1:], value) for name, _, value in base]
    for _ in range(rng.choice([1, 1, 2, 2, 3, 4, 6])):
        word = _draw_word(options, ["a", "b"], rng)
        words.insert(rng.randint(0, len(words)), word)
        if rng.random() < 0.05:
            words.append(Word(word.name, _draw_word(options, ["a"], rng).value))
    # The last of equal names counts.
    last = {word.name: word for word in words}
    for word in words:
        if last[word.name] is not word:
            word.wrong = False
    return words


def _line(word: Word, rng: random.Random, yaml: bool) -> str:
    quote = rng.choice(['"', "'"])
    plain = re.fullmatch(r"[\w.,+-]+", word.value) and rng.random() < 0.7
    value = word.value if plain or not word.value else quote + word.value + quote
    comment = rng.choice(["", "", "", " # -seed 7", "\t# a 'quote\"", "  "])
    if yaml:
        return f"{word.name}: {value}{comment}"
    return (rng.choice(["", "", " ", "\t"]) + f"-{word.name}"
            + (rng.choice([" ", "  ", "\t", " \t "]) + value if value else "") + comment)


def as_file(words: list[Word], rng: random.Random, yaml: bool) -> bytes:
    """The options as an editor on some machine might leave them."""
    lines: list[str] = []
    for word in words:
        lines += rng.choice([[], [], [""], ["# comment"]]) if not yaml else []
        lines.append(_line(word, rng, yaml))
    if rng.random() < 0.05 and not yaml:
        lines.append("#" * 5000)
    ending = rng.choice(["\n", "\n", "\r\n"])
    text = ending.join(lines) + rng.choice(["", ending])
    return rng.choice([b"", b"", b"", b"\xef\xbb\xbf"]) + text.encode()


def _arguments(words: list[Word]) -> list[str]:
    found: list[str] = []
    for word in words:
        found += [f"-{word.name}"] + ([word.value] if word.value else [])
    return found


OUTPUTS = ["-ts_max_steps", "4", "-progress_interval", "0", "-state_output", "out.h5",
           "-energy_monitor", "ascii:energy.csv", "-monitor_interval", "1"]


def _command(trial: Trial, words: list[Word]) -> tuple[Command, str]:
    """The set on the command line, in a file, through a pipe, or in a variable."""
    rng = trial.random
    way = rng.choice(["line", "line", "file", "file", "yaml", "stdin", "variable"])
    ranks = rng.choice([0, 0, 0, 0, 2])
    # Address sanitizer's shadow takes more address space than any limit.
    limits = [] if "ASAN_OPTIONS" in os.environ else ["--as=6000000000"]
    command = Command([], ranks, limits=limits)
    if way == "line":
        command.options = _arguments(words) + OUTPUTS
    elif way == "variable":
        lines = [_line(word, random.Random(0), False).partition("#")[0] for word in words]
        command.variables = {"PETSC_OPTIONS": " ".join(lines)}
        command.options = OUTPUTS
    else:
        data = as_file(words, rng, way == "yaml")
        name = {"file": "run.opts", "yaml": "run.yaml", "stdin": "/dev/stdin"}[way]
        if way == "stdin":
            command.stdin = data
        else:
            (trial.folder / name).write_bytes(data)
        command.options = ["-options_file", name, *OUTPUTS]
    return command, way


def _finite(trial: Trial) -> None:
    with h5py.File(trial.folder / "out.h5") as file:
        for name in ("position", "velocity"):
            if not np.isfinite(file["state"][name][()]).all():
                trial.fail(f"status 0 with a {name} that is no number")
    _, rows, _ = rows_of_table(trial.folder / "energy.csv")
    if not rows or not all(math.isfinite(cell) for row in rows for cell in row):
        trial.fail("status 0 with energies that are no numbers")


def _same_as_on_the_line(trial: Trial, words: list[Word], way: str) -> None:
    """What was read is what was written: the command line gives the same."""
    line = Trial(trial.setting, trial.part, trial.number, f"{trial.number}-line")
    outcome = line.run(Command(_arguments(words) + OUTPUTS))
    if outcome.status != 0:
        trial.fail(f"by {way} status 0, on the command line {outcome.status}: "
                   f"{' '.join(outcome.error_lines())[:200]}")
    else:
        for name in ("out.h5", "energy.csv"):
            if problem := first_difference(trial.folder / name, line.folder / name):
                trial.fail(f"by {way} another result than on the command line: {problem}")
    trial.story += line.story
    line.remove()


def option_trial(trial: Trial) -> None:
    rng = trial.random
    words = draw_set(known_options(trial.setting.binary), rng)
    command, way = _command(trial, words)
    outcome = trial.run(command, 120)
    trial.counts["option sets"] += 1
    if not trial.expect(outcome, 0, 1, 2):
        return
    trial.counts[f"option sets, status {outcome.status}"] += 1
    wrong = [word for word in words if word.wrong]
    if wrong and outcome.status != 1:
        trial.fail(f"status {outcome.status} with -{wrong[0].name} '{wrong[0].value[:40]}'")
    elif outcome.status == 0:
        _finite(trial)
        if way != "line" and not trial.failures:
            _same_as_on_the_line(trial, words, way)
    elif outcome.status == 1 and any((trial.folder / name).exists()
                                     for name in ("out.h5", "energy.csv")):
        trial.fail("status 1, yet something was written")
