"""Times, lengths and energies as people write them."""

from collections.abc import Sequence

Unit = tuple[str, float]

TIME: Sequence[Unit] = (("fs", 1e-15), ("ps", 1e-12), ("ns", 1e-9), ("µs", 1e-6), ("ms", 1e-3),
                        ("s", 1.0))
LENGTH: dict[str, Sequence[Unit]] = {
    "nano": (("Å", 1.0), ("nm", 10.0), ("µm", 1e4), ("mm", 1e7)),
    "si": (("nm", 1e-9), ("µm", 1e-6), ("mm", 1e-3), ("m", 1.0))}
ENERGY: dict[str, Sequence[Unit]] = {
    "nano": (("eV", 1.0), ("keV", 1e3), ("MeV", 1e6)),
    "si": (("aJ", 1e-18), ("fJ", 1e-15), ("pJ", 1e-12), ("nJ", 1e-9), ("µJ", 1e-6), ("mJ", 1e-3),
           ("J", 1.0))}
SECONDS = {"nano": 1e-15, "si": 1.0}  # in a unit of time

GPA = 1e-21 / 1.602176634e-19  # a gigapascal in eV/A^3 (CODATA 2018)
AMU = 1.66053906660e-27 / 1.602176634e-29  # an atomic mass unit in eV fs^2/A^2


def largest_unit(value: float, ladder: Sequence[Unit], least: float = 2.0) -> Unit:
    """The largest unit in which the value is still `least` or more."""
    return next((unit for unit in reversed(ladder) if value >= least * unit[1]), ladder[0])


def length_unit(length: float, units: str) -> Unit:
    return largest_unit(length, LENGTH["si" if units == "si" else "nano"])


def time_text(time: float, units: str) -> str:
    """A time of a state, such as 1.25 ns."""
    seconds = time * SECONDS["si" if units == "si" else "nano"]
    name, size = largest_unit(seconds, TIME, 1.0)
    return f"{seconds / size:.4g} {name}"
