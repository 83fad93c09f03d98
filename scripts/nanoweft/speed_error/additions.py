"""What kinds, rest shapes, links, kinks, bond laws, contacts, walls, holders, temperature and the
driven box cost, and how errors fall with the segments' length, the step or the number of points.

A cost is user time, which other programs on the machine disturb least: the median of ratios of a
run with the term to a run without it next to it in time."""

import csv
import json
import resource
import time
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .. import beams
from ..verification import contacts, kinds, links, rest
from .additions_errors import TERMS
from .matrix import machine, read

COLUMNS = ["kind", "name", "T", "setting", "error",
           *(f"{scene}_{what}" for scene in ("alone", "weave", "periodic")
             for what in ("ns", "ratio", "spread"))]
WEAVE = {"scene": "weave", "weave_fibres": "24,24", "weave_segments": 120, "damping_local": 0.4,
         "ts_dt": 15}
SEGMENTS = 2 * 24 * 120
# Bonds alone, and with pair forces; so many steps take about a second.
SCENES = {"alone": (WEAVE | {"pair": "none"}, 6000), "weave": (WEAVE, 1000),
          "periodic": (WEAVE | {"weave_periodic": None}, 1000)}
CONTACT = {"pair": "contact", "contact_modulus": 20}
FLOOR = {"walls": "floor", "floor_point": "0,0,-16", "floor_axis": "0,0,1", "floor_modulus": 20}
HEATED = {"temperature": 300, "temperature_damping": 1e-4, "damping_local": 0}
WET = {"pair": "capillary,contact", "contact_modulus": 500, "capillary_tension": 0.0045,
       "capillary_volume": 2000}
LINKED = {"links_density": 0.02, "links_distance": 24}
SPUN = {"bc": "end", "end_region": "-1e5,-1e5,-1e5,20,1e5,1e5", "end_axis": "1,0,0",
        "end_centre": "0,0,0", "end_spin": 1e-12}


class Case(NamedTuple):
    """A term's options; `scenes`: where it is timed."""
    name: str
    options: dict
    scenes: tuple


CASES = (
    Case("nothing (noise of the measurement)", {}, ("alone", "weave")),
    Case("off: one kind, with a name", {"kinds": "a"}, ("weave",)),
    Case("off: rest curvature and twist 0", {"fibre_rest_curvature": "0,0", "fibre_rest_twist": 0},
         ("alone",)),
    Case("off: links at a density of 0", {"links_density": 0}, ("alone",)),
    Case("two kinds, the same tube", {"kinds": "a,b", "weave_kinds": "a,b"}, ("weave",)),
    Case("rest shape of a kind", {"fibre_rest_curvature": "0,1e-4"}, ("alone",)),
    Case("rest shape of each bond, as woven", {"weave_rest": "shaped"}, ("alone",)),
    Case("kinks, at 1/(275 A)", {"fibre_kink_curvature": 1 / 275}, ("alone", "weave")),
    Case("links, EVM bonds", LINKED, ("weave",)),
    Case("links, springs", LINKED | {"link_law": "spring"}, ("weave",)),
    Case("internal viscosity, 1 fs", {"fibre_retardation": 1}, ("alone",)),
    Case("plastic flow, never reached", {"fibre_yield_strain": 0.5}, ("alone",)),
    Case("a wall below", FLOOR, ("alone", "weave")),
    Case("temperature", HEATED, ("alone", "weave")),
    Case("holders that spin", SPUN, ("alone", "weave")),
    Case("a box that is stretched", {"deform_x": "rate", "deform_x_rate": 1e-9}, ("periodic",)),
    Case("a box that is sheared", {"deform_xy": "rate", "deform_xy_rate": 1e-9}, ("periodic",)),
    Case("hydrogen in place of vdw", {"pair": "hydrogen", "hydrogen_energy": 0.02,
                                      "hydrogen_gap": 3}, ("weave",)),
    Case("hamaker in place of vdw", {"pair": "hamaker", "hamaker_constant": 40, "hamaker_gap": 3.5,
                                     "pair_gap_cutoff": 40}, ("weave",)),
    Case("capillary and contact in place of vdw", WET, ("weave",)),
    Case("contact in place of vdw", CONTACT, ("weave",)),
    Case("contact with friction in place of vdw", CONTACT | {"contact_friction": 0.3}, ("weave",)),
)


@dataclass
class Cost:
    """User time of a segment-step, ns; ratio to one without the term, half the ratio's range."""
    nanoseconds: float
    ratio: float
    spread: float


def seconds(program, options, steps):
    """User time of a run."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    program.run(options | {"ts_max_steps": steps})
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def costs(program, scene, rounds, names):
    """Name of each case that is timed on a scene -> cost; a plain run before every second one."""
    base, steps = SCENES[scene]
    cases = {case.name: base | case.options for case in CASES
             if scene in case.scenes and case.name in names}
    if not cases:
        return {}
    start = min(seconds(program, base, 1) for _ in range(3))
    times, ratios = ({name: [] for name in cases} for _ in range(2))
    for _ in range(rounds):
        for k, (name, options) in enumerate(cases.items()):
            if k % 2 == 0:
                without = seconds(program, base, steps + 1) - start
            times[name].append(seconds(program, options, steps + 1) - start)
            ratios[name].append(times[name][-1] / without)
    return {name: Cost(1e9 * float(np.median(times[name])) / steps / SEGMENTS,
                       float(np.median(ratios[name])), 0.5 * float(np.ptp(ratios[name])))
            for name in cases}


def ring(times):
    """A ring, 64 diameters around, at rest as a ring and pinched."""
    return rest.shrinkage(round(64 / times))[0] - 1


def ladder(times):
    """A ladder of 40 diameters with ten rungs."""
    length, bonds = 40 * beams.TUBE.T, round(40 / times)
    shape = beams.Ladder(length, 3 * beams.TUBE.T, 2e4, 1e-3 * 6 * beams.TUBE.EJ / length**2)
    places = np.arange(1, 11) * length / 10
    found = links.deflection(f"speed_ladder_{times:g}", shape, bonds + 1, bonds // 10)
    return found / shape.deflection(places) - 1


def kink(times):
    """A tube of 16 diameters under 0.9 of its critical moment, against M L/EJ."""
    T, bonds, moment = times * beams.TUBE.T, round(16 / times), 0.9 * beams.TUBE.EJ / 275
    angle = links.turned(f"speed_kink_{times:g}", moment, bonds + 1,
                         "-relax_method fire -relax_force 1e-7 -ts_max_steps 400000 "
                         f"-fibre_kink_curvature {1 / 275!r}", T)
    return angle / (moment * bonds * T / beams.TUBE.EJ) - 1


def adhesion(times):
    """A (10,10) tube, cut into other segments, beside one twice as thick; default points."""
    thin = kinds.Tube(beams.TUBE.radius, times * beams.TUBE.T)
    exact, found = kinds.adhesion_of(f"speed_kinds_{times:g}", thin, kinds.DOUBLE)
    return found / exact - 1


def contact(times):
    """Two fibres crossed at a right angle, 0.23 of a segment off a centre."""
    return contacts.crossed_force(f"speed_contact_{times:g}", 0.23, times * beams.TUBE.T) - 1


def wall(times):
    """A fibre pressed on a floor."""
    return contacts.pressed(f"speed_wall_{times:g}", times * beams.TUBE.T)[0] - 1


ERRORS = {"kinds: adhesion of two unequal tubes": adhesion, "rest shape: ring, pinched": ring,
          "links: ladder, bent": ladder, "kinks: tube at 0.9 of its critical moment": kink,
          "contact: crossed fibres": contact, "wall: a fibre on a floor": wall}
LENGTHS = (0.5, 1, 2, 4)
TOO_SLOW = "rest shape: ring, pinched", 0.5  # half a minute by FIRE


def measure(output, program, rounds, command, words=()):
    """Writes additions.csv: facts as JSON in a comment, then the rows. With `words`, rows whose
    names contain none of them stay as they are there."""
    def wanted(name):
        return not words or any(word in name for word in words)
    begun, rows = time.time(), []
    for name, error in ERRORS.items():
        rows += [{"kind": "error", "name": name, "T": times, "error": abs(error(times))}
                 for times in LENGTHS if (name, times) != TOO_SLOW and wanted(name)]
    for term in TERMS:
        rows += [{"kind": "setting", "name": term.name, "setting": f"{setting:g} {term.unit}",
                  "error": abs(term.error(setting))} for setting in term.settings
                 if wanted(term.name)]
    found, names = {}, {case.name for case in CASES if wanted(case.name)}
    for scene in SCENES:
        print(f"{time.time() - begun:5.0f} s  costs: {scene}", flush=True)
        found[scene] = costs(program, scene, rounds, names)
    for case in CASES:
        if case.name not in names:
            continue
        row = {"kind": "cost", "name": case.name}
        for scene in case.scenes:
            one = found[scene][case.name]
            row |= {f"{scene}_ns": one.nanoseconds, f"{scene}_ratio": one.ratio,
                    f"{scene}_spread": one.spread}
        rows.append(row)
    if words:
        rows = read(output / "additions.csv")[1] + rows
        # A later row of a name takes the place of the earlier one.
        rows = list({(r["kind"], r["name"], r.get("T"), r.get("setting")): r
                     for r in rows}.values())
    facts = {"machine": machine(), "command": command, "rounds": rounds,
             "seconds": round(time.time() - begun), "links": links_made(program)}
    with open(output / "additions.csv", "w", newline="") as out:
        out.write(f"# {json.dumps(facts)}\n")
        table = csv.DictWriter(out, COLUMNS, lineterminator="\n")
        table.writeheader()
        for r in rows:
            table.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in r.items()})


def links_made(program):
    """Of the timed weave with links."""
    return round(program.run(WEAVE | LINKED | {"ts_max_steps": 0}).number(r"(\d+) links: "))
