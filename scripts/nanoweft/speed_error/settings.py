"""The axes of the matrix and their settings."""

from dataclasses import dataclass, field

from .. import options as option_files
from ..generators import LENGTH
from ..runs import ROOT

PAPER = {"pair_points": 3, "vdw_splice": "kink", "pair_switch": 3 * LENGTH,
         "pair_cutoff": 4 * LENGTH}
DEFAULT = dict(PAPER, vdw_splice="smooth")
FINE = dict(DEFAULT, pair_points=9)
WIDE = (6, 7)
RANGES = ((2, 3), (2.5, 3.5), (3, 4), (4, 5), WIDE)
# Points a segment that keep about the same number of points per length.
POINTS_OF_LENGTH = {0.5: 2, 1: 3, 2: 6, 4: 9}
FILES = ("fast", "balanced", "paper", "reference")


@dataclass
class Setting:
    """`options` are about pair forces; a cost is that of a step of `dt` fs."""
    axis: str
    name: str
    options: dict = field(default_factory=dict)
    dt: float = 20.0
    length: float = LENGTH
    same_work: str = ""  # the setting of this axis that is timed in its place
    errors: list = field(default_factory=list)

    def error(self, scene, measure, value):
        self.errors.append((scene, measure, abs(float(value))))


def ranged(options, wide):
    return dict(options, pair_switch=wide[0] * LENGTH, pair_cutoff=wide[1] * LENGTH)


def option_file(name):
    options = option_files.read(ROOT / "runs" / "settings" / f"{name}.opts")
    dt = float(options.pop("ts_dt"))
    number = {key: int(value) if key.endswith("points") else float(value)
              for key, value in options.items() if key != "vdw_splice"}
    return Setting("settings", name, options | number, dt)


def precisions(quick):
    """Settings in doubles and the same in single precision."""
    points = {"3": DEFAULT, "5": dict(DEFAULT, pair_points=5),
              "3, 1 beyond 2T": dict(DEFAULT, pair_far_points=1, pair_far_from=2 * LENGTH),
              "5, 1 beyond 2T": dict(DEFAULT, pair_points=5, pair_far_points=1,
                                     pair_far_from=2 * LENGTH)}
    return [Setting("precision", f"{name} {precision}",
                    dict(points[name], pair_precision=precision))
            for name in (("3",) if quick else points) for precision in ("double", "single")]


def all_settings(quick, single):
    """`single`: whether the program offers single precision."""
    def pick(full, few):
        return few if quick else full

    made = [option_file(name) for name in pick(FILES, ("fast", "paper"))]
    made += [Setting("time step", f"{dt} fs", DEFAULT, dt)
             for dt in pick((5, 10, 15, 20, 25), (10, 20))]
    for splice in ("smooth", "kink"):
        for n in pick(range(1, 10), (3, 5)):
            # The splice changes no work: it is timed with both at three numbers of points.
            same = f"{n} smooth" if splice == "kink" and n not in (1, 3, 5) else ""
            options = dict(DEFAULT, pair_points=n, vdw_splice=splice)
            made.append(Setting("points", f"{n} {splice}", options, same_work=same))
    for wide in pick(RANGES, RANGES[1:3]):
        made.append(Setting("range", "{}T to {}T".format(*wide), ranged(DEFAULT, wide)))
    for n in pick((3, 4, 5), (5,)):
        for m in pick((1, 2), (1,)):
            for begin in pick((1.5, 1.75, 2, 2.5), (2,)):
                options = dict(DEFAULT, pair_points=n, pair_far_points=m,
                               pair_far_from=begin * LENGTH)
                made.append(Setting("far points", f"{n}, {m} beyond {begin}T", options))
    for accuracy in pick((0.1, 0.05, 0.02, 0.01), (0.05,)):
        made.append(Setting("accuracy", f"to {accuracy:g}",
                            {"vdw_splice": "smooth", "pair_accuracy": accuracy,
                             "pair_precision": "double"}))
    for times in pick((0.5, 1, 2, 4), (1, 2)):
        options = dict(DEFAULT, pair_points=POINTS_OF_LENGTH[times])
        made.append(Setting("length", f"{times} x 2 rf", options, length=times * LENGTH))
    return made + (precisions(quick) if single else [])
