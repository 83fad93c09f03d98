#!/usr/bin/python3
"""Shear modulus of random networks against the number of links a fibre has.

Each network starts sheared as a whole, which strains every fibre as an affine deformation does, and
comes to rest in its box. The energy that stays over that at the start is the modulus over its
affine value."""
from __future__ import annotations

import argparse
import pathlib
import sys
import tempfile
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "scripts"))
from nanoweft import generators, runs, tables  # noqa: E402
from nanoweft.arguments import count, positives  # noqa: E402
from nanoweft.generators import LENGTH, Network  # noqa: E402
from nanoweft.problems import RunFailed, command  # noqa: E402

SHEAR = 1e-6        # so small that fibres carry no less for being compressed
HINGED = 4.26       # links a fibre has at the onset of rigidity (README.md)
BENT = 0.2          # of the affine modulus, up to which a power law is fitted
DENSITIES = (300, 320, 345, 370, 400, 440, 500, 600, 750)
Points = NDArray[np.float64]


def share_left(network: Network, share: float, folder: str,
               more: Sequence[str]) -> tuple[float, float]:
    """Links a fibre has, and the modulus over the affine one."""
    links = generators.network(f"{folder}/network.h5", network, share, SHEAR)
    done = runs.run(["-options_file", str(HERE / "run.opts"), "-scene_file", f"{folder}/network.h5",
                     "-energy_monitor", f"ascii:{folder}/energy.csv",
                     "-state_output", f"{folder}/relaxed.h5", *more])
    if done.returncode:
        raise RunFailed(done.stderr.strip() or done.stdout.strip())
    if "converged" not in done.stdout:
        print(f"measure.py: {network} is not at rest after -ts_max_steps", file=sys.stderr)
    elastic = tables.read(f"{folder}/energy.csv").elastic
    return 2 * links / network.fibres, float(elastic[-1] / elastic[0])


def affine(network: Network) -> float:
    """The affine modulus over ES/L of one fibre: length of fibre per area, over 8."""
    area = network.across * network.rows * np.sqrt(0.75) * LENGTH**2
    length = (network.segments - 1) * LENGTH
    return float(network.fibres * length / area / 8 * length)


def fit(points: Points, onset: float) -> tuple[float, float]:
    """Exponent of (N - onset) and rms of the logarithm's error."""
    x, y = np.log(points[:, 0] - onset), np.log(points[:, 1])
    slope, height = np.polyfit(x, y, 1)
    return float(slope), float(np.sqrt(np.mean((y - height - slope * x)**2)))


def best_onset(points: Points) -> float:
    """The onset with which a power law fits best."""
    below = points[:, 0].min() - np.geomspace(0.02, 3, 300)
    return float(min(below, key=lambda onset: fit(points, onset)[1]))


def measure(options: argparse.Namespace) -> Points:
    """Rows of links a fibre, modulus over ES/L, and over the affine one: means of all seeds."""
    rows = []
    print("# fibres, links a fibre, G L/ES, G/affine, its standard error", flush=True)
    with tempfile.TemporaryDirectory(prefix="nanoweft-network-") as folder:
        for fibres, share in zip(options.fibres, options.share):
            networks = [Network(int(fibres), options.segments, options.across, seed)
                        for seed in range(1, options.seeds + 1)]
            found = [share_left(network, share, folder, options.options) for network in networks]
            links, left = np.mean(found, axis=0)
            error = np.std(found, axis=0)[1] / np.sqrt(max(1, options.seeds - 1))
            rows.append((links, left * affine(networks[0]), left))
            print(f"{int(fibres):6d} {links:8.3f} {rows[-1][1]:11.4e} {left:11.4e} {error:8.1e}",
                  flush=True)
    return np.array(rows)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fibres", type=positives, default=DENSITIES, metavar="F[,F...]",
                        help="of each network (default: %(default)s)")
    parser.add_argument("--share", type=positives, default=(1.0,), metavar="S[,S...]",
                        help="of the crossings that are tied: for all or for each (default: 1)")
    parser.add_argument("--segments", type=count, default=20, metavar="N",
                        help="of a fibre (default: %(default)s)")
    parser.add_argument("--across", type=count, default=120, metavar="N",
                        help="segments along the box (default: %(default)s)")
    parser.add_argument("--seeds", type=count, default=3, metavar="N",
                        help="networks of each density (default: %(default)s)")
    parser.add_argument("options", nargs="*", metavar="-- OPTION",
                        help="of nanoweft, more than run.opts has")
    options = parser.parse_args()
    wide = max(len(options.fibres), len(options.share))
    options.fibres, options.share = (values * (wide if len(values) == 1 else 1)
                                     for values in (options.fibres, options.share))
    if len(options.fibres) != len(options.share):
        parser.error("--fibres and --share: one for all, or as many of both")
    return options


def main() -> None:
    points = measure(arguments())
    # Beyond, fibres are stretched more and more instead of bent.
    bent = points[(points[:, 0] > HINGED) & (points[:, 2] < BENT)]
    if len(bent) < 4:
        return
    for name, onset in ("published", HINGED), ("that fits best", best_onset(bent)):
        slope, error = fit(bent, onset)
        print(f"# G ~ (N - {onset:.2f})^{slope:.2f}, the onset {name}; below {BENT:g} of affine,"
              f" rms of ln G {error:.3f}")


if __name__ == "__main__":
    command(main)
