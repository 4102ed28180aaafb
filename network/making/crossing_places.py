"""Where the level crossings (踏切) of a list lie: on one track, in the section whose kilometrage they have."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

from network.errors import InputError
from network.files.crossings import LONG_S
from network.making.crossing_list import CrossingRow, ListedCrossings
from network.making.layout import LaidSection, LineLayout
from network.model import CrossingClass
from network.units import metres

_NO_ROAD: Final = ("points", "portal")


@dataclass(frozen=True, slots=True)
class LaidCrossing:
    """A crossing with its id and the section it lies in."""

    id: str
    row: CrossingRow
    section: str

    @property
    def is_asked(self) -> bool:
        """Whether units ask it by radio: all but those without a device."""
        return self.row.kind != CrossingClass.NO_DEVICE.value

    def asked_m(self, speed_mps: float) -> tuple[float, float]:
        """Its place, m, and from how far, m, at the greatest speed: before as long a warning as is not reported."""
        return metres(self.row.km), speed_mps * LONG_S


def laid_crossings(
    listed: ListedCrossings, layout: LineLayout, taken: Iterable[str]
) -> Iterator[LaidCrossing]:
    """Each where it lies. InputError for an id that is taken, and for one where no single track is."""
    names = set(taken)
    for i, row in enumerate(listed.rows):
        key = f"crossings[{i}]"
        name = row.id or f"X{i + 1}"
        if name in names:
            raise InputError(listed.file, f"{key}.id", name, "an id that no other crossing or terminal has")
        names.add(name)
        middle_m, half_m = metres(row.km), row.width_m / 2.0
        here = [
            section for section in layout.sections if _meets(section, middle_m - half_m, middle_m + half_m)
        ]
        whole = [one for one in here if _within(one, middle_m - half_m, middle_m + half_m)]
        fouled = [p.id for p in layout.points if p.from_m < middle_m + half_m and p.to_m > middle_m - half_m]
        if len(here) != 1 or len(whole) != 1 or fouled or here[0].kind in _NO_ROAD:
            there = ", ".join((*(section.id for section in here), *fouled)) or "nothing of the line"
            expected = f"a place on one track, clear of points and ends of sections (there: {there})"
            raise InputError(listed.file, f"{key}.km", row.km, expected)
        yield LaidCrossing(name, row, here[0].id)


def _meets(section: LaidSection, from_m: float, to_m: float) -> bool:
    if section.from_m is None or section.to_m is None:
        return False
    return section.from_m < to_m and section.to_m > from_m


def _within(section: LaidSection, from_m: float, to_m: float) -> bool:
    low_m, high_m = section.from_m, section.to_m
    return low_m is not None and high_m is not None and low_m <= from_m and to_m <= high_m
