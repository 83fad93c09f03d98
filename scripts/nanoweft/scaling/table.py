"""Rows of the table: one partition of one scene among some ranks."""

import csv

from . import metis, model, partition

KINDS = "dmda,metis,metis:8"


def owners(kind, scene, reach, work, ranks, piece):
    """`metis:8` is METIS on pieces of 8, plain `metis` on pieces of `piece`;
    `dmda:2` has cells of half the list range."""
    name, _, length = kind.partition(":")
    if name == "dmda":
        return partition.dmda(scene, reach / int(length or 1), ranks, work)
    return metis.divide(scene, reach, ranks, work, int(length or piece))


def row(case, kind, ranks, loads, costs, serial):
    share = ranks / loads.ranks  # of the ranks, when `loads` is a sample
    time = model.step(loads, costs, ranks)
    slow = model.step(loads, costs.slower_network(), ranks)
    bare = model.step(loads, costs.slower_network(0, 0), ranks)
    at_once = model.step(loads, costs, ranks, late=False)
    return {"case": case, "kind": kind, "ranks": ranks, "segments_per_rank": loads.owned.mean(),
            "imbalance": loads.imbalance, "ghosts_per_segment": loads.ghosts.sum() / loads.segments,
            "ghosts_mean": loads.ghosts.mean(), "ghosts_max": loads.ghosts.max(),
            "messages_mean": loads.messages.mean(), "messages_max": loads.messages.max(),
            "kB_per_step_max": 0.064 * loads.ghosts.max(), "cut_bonds": share * loads.cut_bonds,
            "cut_pairs_percent": 100 * loads.cut_pairs / loads.pairs, "ms": 1e3 * time,
            "ms_at_once": 1e3 * at_once,
            "efficiency": serial / (ranks * time), "network_percent": 100 * (1 - bare / time),
            "ms_slow_network": 1e3 * slow, "efficiency_slow_network": serial / (ranks * slow)}


FORMATS = {"imbalance": ".3f", "ghosts_per_segment": ".4f", "messages_mean": ".1f",
           "cut_pairs_percent": ".2f",
           "ms": ".4g", "ms_at_once": ".4g",
           "efficiency": ".3f", "network_percent": ".1f", "ms_slow_network": ".4g",
           "efficiency_slow_network": ".3f", "kB_per_step_max": ".1f", "case": "", "kind": ""}


def write_csv(rows, file):
    with open(file, "w", newline="") as f:
        out = csv.writer(f)
        out.writerow(rows[0])
        for r in rows:
            out.writerow([format(v, FORMATS.get(k, ".0f")) for k, v in r.items()])


HEADS = {"kind": "partition", "ranks": "ranks", "imbalance": "imbalance",
         "ghosts_per_segment": "ghosts a segment",
         "ghosts_max": "ghosts, most", "messages_mean": "messages, mean", "messages_max": "most",
         "kB_per_step_max": "kB a step, most", "cut_bonds": "cut bonds",
         "cut_pairs_percent": "cut pairs, %",
         "ms": "ms a step", "ms_at_once": "if ranks agreed at once",
         "efficiency": "efficiency", "network_percent": "of it network, %",
         "efficiency_slow_network": "efficiency, network 10 x slower"}


def markdown(rows):
    lines = ["| " + " | ".join(HEADS.values()) + " |", "|" + "---|" * len(HEADS)]
    for r in rows:
        lines.append("| " + " | ".join(format(r[k], FORMATS.get(k, ".0f")) for k in HEADS) + " |")
    return "\n".join(lines)
