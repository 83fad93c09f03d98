"""The whole measurement: errors side by side, costs one at a time, all into matrix.csv."""

import csv
import json
import os
import time

from .. import generators
from . import terms
from .axes import Axes
from .program import Program
from .settings import all_settings
from .timing import Stopwatch

COLUMNS = ["axis", "setting", "scene", "measure", "error", "ns_per_segment_step",
           "pairs_per_second",
           "step_cost", "step_cost_spread", "relative_cost", "step_fs", "segment_A",
           "stable_step_fs"]


def machine():
    with open("/proc/cpuinfo") as file:
        names = [line.split(":")[1].strip() for line in file if line.startswith("model name")]
    return f"{os.cpu_count()} logical cores of {names[0] if names else 'an unknown processor'}"


def row(setting, scene, measure, error, cost):
    """A row of the table; a setting's cost counts for the same length of fibre
    and simulated time."""
    same = {"axis": setting.axis, "setting": setting.name, "scene": scene, "measure": measure,
            "error": error, "step_fs": setting.dt, "segment_A": setting.length}
    if setting.axis == "time step":
        # All steps cost alike.
        same["relative_cost"] = 20.0 / setting.dt
    elif cost:
        same |= cost_columns(cost, 20.0 / setting.dt * 13.56 / setting.length)
    return same


def cost_columns(cost, factor=1.0):
    return {"ns_per_segment_step": cost.nanoseconds, "pairs_per_second": cost.pairs_per_second,
            "step_cost": cost.ratio, "step_cost_spread": cost.spread,
            "relative_cost": cost.ratio * factor, "stable_step_fs": cost.limit}


def timed_options(setting, axes):
    """What is timed for a setting on the bundle;
    segments of other lengths have their own bundle."""
    if setting.axis != "length":
        return setting.options | {"ts_dt": setting.dt}
    file = generators.bundle(axes.folder / f"bundle{setting.length:g}.h5", setting.length,
                             axes.rings)
    # Small steps, so that the shortest segments are stable.
    return setting.options | {"ts_dt": 5.0, "scene_file": file,
                              "fibre_segment_length": setting.length}


def costs(stopwatch, axes, settings):
    """(axis, name, scene) -> cost."""
    found = {}
    for scene, file in axes.scenes.items():
        timed = [s for s in settings if not s.same_work and s.axis != "time step"]
        cases = {(s.axis, s.name): timed_options(s, axes) for s in timed
                 if s.axis != "length" or scene == "bundle"}
        for (axis, name), cost in stopwatch.costs(file, cases).items():
            found[axis, name, scene] = cost
    for s in settings:
        for scene in axes.scenes:
            if s.same_work:
                found[s.axis, s.name, scene] = found[s.axis, s.same_work, scene]
        if s.axis == "length":
            # As large a part of the stable step as 20 fs is for the paper's setting.
            s.dt = 20 / 29.41 * found[s.axis, s.name, "bundle"].limit
    return found


def measure(output, work, quick, rounds, workers, command):
    """Writes matrix.csv: facts about the run as JSON in a comment, then the rows."""
    begun, say = time.time(), lambda what: print(f"{time.time() - begun:5.0f} s  {what}",
                                                 flush=True)
    program = Program(work, workers)
    say("scenes")
    axes = Axes(program, work, quick)
    settings = all_settings(quick, axes.single_offered())
    say("errors")
    axes.measure(settings)
    summed = {s.axis for s in settings} - {"time step", "settings", "precision", "accuracy"}
    checked = [s for s in settings if s.axis in summed]
    facts = {"machine": machine(), "command": command, "rounds": rounds, "weave": axes.weave_size,
             "tubes": axes.tubes, "finest": axes.finest,
             "adhesion": {s: axes.adhesion(s) for s in ("smooth", "kink")},
             "sums": axes.check_sums(checked)}
    losses = terms.errors(program, work)
    say("costs")
    seconds = 0.05 if quick else 0.3
    stopwatch = Stopwatch(program, rounds, seconds)
    cost = costs(stopwatch, axes, settings)
    rows = []
    for s in settings:
        for scene, name, error in s.errors:
            timed = scene if scene in axes.scenes else "bundle"
            rows.append(row(s, scene, name, error, cost.get((s.axis, s.name, timed))))
        seen = {scene for scene, _, _ in s.errors}
        rows += [row(s, scene, "", "", cost[s.axis, s.name, scene]) for scene in axes.scenes
                 if scene not in seen and (s.axis, s.name, scene) in cost]
    say("what a scene can leave out")
    # These differ by little: more rounds.
    file, stopwatch = axes.scenes["weave"], Stopwatch(program, (1 if quick else 3) * rounds,
                                                      seconds)
    for name, one in terms.costs(stopwatch, file, work).items():
        lost = [x for x in losses if x[0] == name] or [(name, "weave", "", "")]
        rows += [{"axis": "terms", "setting": name, "scene": scene, "measure": what, "error": error,
                  "step_fs": 20.0} | cost_columns(one) for _, scene, what, error in lost]
    facts["events"] = terms.events(stopwatch, file, work)
    facts["seconds"] = round(time.time() - begun)
    with open(output / "matrix.csv", "w", newline="") as out:
        out.write(f"# {json.dumps(facts)}\n")
        table = csv.DictWriter(out, COLUMNS, lineterminator="\n")
        table.writeheader()
        for r in rows:
            table.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in r.items()})
    say("done")


def read(file):
    """The facts and the rows of a matrix.csv, numbers as numbers."""
    def value(text):
        try:
            return float(text)
        except ValueError:
            return text or None
    with open(file, newline="") as f:
        facts = json.loads(f.readline().lstrip("# "))
        rows = [{k: value(v) for k, v in r.items()} for r in csv.DictReader(f)]
    return facts, rows
