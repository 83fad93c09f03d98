"""CSV tables: lines that begin with # (provenance), a line of names, rows of numbers."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .problems import Unusable
from .units import SECONDS

Array = NDArray[Any]
ELASTIC = ("stretch", "shear", "bending", "torsion")


@dataclass
class Table:
    name: str
    columns: dict[str, Array]
    comments: list[str] = field(default_factory=list)  # without their #

    def __getitem__(self, column: str) -> Array:
        return self.columns[column]

    def __contains__(self, column: str) -> bool:
        return column in self.columns

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def need(self, *columns: str) -> Table:
        """Itself; Unusable where a column or the time is missing."""
        missing = [column for column in columns if column not in self]
        if missing or not {"time_fs", "time_s"} & set(self):
            raise Unusable(f"{self.name}: no column {(missing or ['time_fs'])[0]}, "
                           "so not the right table")
        return self

    @property
    def units(self) -> str:
        return "nano" if "time_fs" in self else "si"

    @property
    def time(self) -> Array:
        """In seconds."""
        return np.asarray(self["time_fs" if "time_fs" in self else "time_s"] * SECONDS[self.units])

    @property
    def elastic(self) -> Array:
        return np.asarray(sum(self[part] for part in ELASTIC))

    @property
    def motion(self) -> Array:
        return np.asarray(self["kinetic"] + self["rotational"])

    @property
    def balance(self) -> Array:
        """What would be constant if time steps had no error."""
        balance = self["total"] + self["damped"] + self["broken"] - self["external"]
        for column, sign in (("friction", 1), ("heat", -1)):  # that only some runs have
            if column in self:
                balance = balance + sign * self[column]
        return np.asarray(balance)

    @property
    def options(self) -> list[str]:
        """The options of the run by which it was written, a line each;
        empty where it does not say."""
        return [line for line in self.comments if line.startswith("-")]

    @property
    def program(self) -> str:
        """Name and version of the program, where the table says it."""
        first = self.comments[0] if self.comments else ""
        return first if first.startswith("nanoweft") else ""


def read(name: str | os.PathLike[str]) -> Table:
    """A table of numbers. A last line that is not complete, because the run goes on,
    is left out."""
    try:
        with open(name, newline="") as file:
            lines = file.readlines()
    except OSError as error:
        raise Unusable(f"{name}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise Unusable(f"{name}: not a CSV file") from None
    comments = [line[1:].strip() for line in lines if line.startswith("#")]
    try:
        rows = [row for row in csv.reader(line for line in lines if not line.startswith("#"))
                if row]
    except csv.Error:
        raise Unusable(f"{name}: not a CSV file") from None
    header = [cell.strip() for cell in rows[0]] if rows else []
    whole = len(lines) == 0 or lines[-1].startswith("#") or lines[-1].endswith("\n")
    own = bool(comments) and comments[0].startswith("nanoweft")
    if len(rows) > 1 and (len(rows[-1]) < len(header) or (own and not whole)):
        rows.pop()
    try:
        numbers = np.array(rows[1:], float).reshape(len(rows[1:]), len(header))
    except ValueError:
        raise Unusable(f"{name}: a line without {len(header)} numbers") from None
    return Table(str(name), dict(zip(header, numbers.T)), comments)
