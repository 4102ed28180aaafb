"""A line made by hand, A |S1| L |S2| M |S3| B, and its trains: the figures are those of docs/capacity.md.

Times are s. A train is let into a section SET_S before it starts, and what it leaves is free FREE_S after it has come
to the next place (a place that it leaves: after it has started).
"""

import math
from dataclasses import dataclass
from itertools import pairwise

from network.model import Direction
from study.capacity.legs import SetLeg, legs_of
from study.capacity.occupation import Occupation, OccupationPart, Slice

SET_S = 10.0  # 2 request, 1 air, 1 grant, 4 throw, 2 proof
FREE_S = 15.0  # 5 length, 6 bound, 4 release
RUN_S = {"S1": 300.0, "S2": 240.0, "S3": 180.0}
DWELL_S = {"L": 60.0, "M": 30.0}
PLACES = ("A", "L", "M", "B")
SECTIONS = ("S1", "S2", "S3")
SETTING = (
    (OccupationPart.REQUEST, 2.0),
    (OccupationPart.AIR, 1.0),
    (OccupationPart.GRANT, 1.0),
    (OccupationPart.THROW, 4.0),
    (OccupationPart.PROOF, 2.0),
)
FREEING = ((OccupationPart.LENGTH, 5.0), (OccupationPart.BOUND, 6.0), (OccupationPart.RELEASE, 4.0))


@dataclass(frozen=True)
class Made:
    """A train: where it starts (A down, B up) and when, s. `loop`: where there are two tracks beside A and B."""

    number: str
    direction: Direction
    starts_s: float
    loop: str = "L"
    throw_s: float = 4.0

    def track(self, place: str) -> str:
        """Down trains are on track 1, up trains on track 2, where there are two."""
        two = place in {"A", "B", self.loop}
        return f"{place}.{1 if self.direction is Direction.DOWN or not two else 2}"

    @property
    def set_s(self) -> float:
        return SET_S + self.throw_s - 4.0

    def setting(self, at_s: float) -> list[Slice]:
        slices: list[Slice] = []
        for part, usual_s in SETTING:
            length_s = self.throw_s if part is OccupationPart.THROW else usual_s
            slices.append(Slice(part, at_s, at_s + length_s))
            at_s += length_s
        return slices

    def occupations(self) -> list[Occupation]:
        down = self.direction is Direction.DOWN
        places = PLACES if down else PLACES[::-1]
        sections = SECTIONS if down else SECTIONS[::-1]
        leaves_s, found = self.starts_s, list[Occupation]()
        came: tuple[float, float, float] = (-math.inf, -math.inf, -math.inf)  # let in, front in, stands
        for (here, there), section in zip(pairwise(places), sections, strict=True):
            let_s, comes_s = leaves_s - self.set_s, leaves_s + RUN_S[section]
            found.append(self.place(here, came, leaves_s))
            slices = [*self.setting(let_s), Slice(OccupationPart.RUN, leaves_s, comes_s), *freeing(comes_s)]
            found.append(self.one(section, slices, leaves_s, comes_s))
            came = (let_s, comes_s, comes_s)
            leaves_s = comes_s + DWELL_S.get(there, 0.0)
        found.append(self.place(places[-1], came, math.inf))
        return found

    def place(self, place: str, came: tuple[float, float, float], leaves_s: float) -> Occupation:
        let_s, enters_s, stands_s = came
        if math.isinf(enters_s):
            slices = [Slice(OccupationPart.READY, leaves_s - 100.0, leaves_s), *freeing(leaves_s)]
            return self.one(self.track(place), slices, enters_s, leaves_s)
        slices = [*self.setting(let_s), Slice(OccupationPart.APPROACH, let_s + self.set_s, enters_s)]
        if math.isinf(leaves_s):
            slices.append(Slice(OccupationPart.LAYOVER, stands_s, stands_s))
        else:
            slices += [Slice(OccupationPart.DWELL, stands_s, leaves_s), *freeing(leaves_s)]
        return self.one(self.track(place), slices, enters_s, leaves_s)

    def one(self, section: str, slices: list[Slice], enters_s: float, leaves_s: float) -> Occupation:
        return Occupation(
            section, self.number, self.number, self.direction, tuple(slices), enters_s, leaves_s
        )


def freeing(at_s: float) -> list[Slice]:
    slices: list[Slice] = []
    for part, length_s in FREEING:
        slices.append(Slice(part, at_s, at_s + length_s))
        at_s += length_s
    return slices


def day(loop: str = "L", throw_s: float = 4.0) -> list[Made]:
    """Six trains: 1 down meets 2 up in the loop, 3 down is alone, 4 down meets 5 up, 6 up is alone."""
    at_s = {"1": 3600.0, "3": 7200.0, "4": 10800.0, "6": 14400.0}
    to_loop_s = {"L": 300.0, "M": 300.0 + 60.0 + 240.0}[loop]
    back_s = {"L": 180.0 + 30.0 + 240.0, "M": 180.0}[loop]
    for down, up in (("1", "2"), ("4", "5")):
        at_s[up] = at_s[down] + to_loop_s - back_s  # both come to the loop at once
    downs = {"1", "3", "4"}
    return [
        Made(n, Direction.DOWN if n in downs else Direction.UP, at_s[n], loop, throw_s) for n in sorted(at_s)
    ]


def legs(trains: list[Made]) -> tuple[SetLeg, ...]:
    made = [one for train in trains for one in train.occupations()]
    return legs_of(made, lambda section: "." in section)


def held(
    section: str, train: str, from_s: float, to_s: float, *, down: bool = True, stays: bool = False
) -> Occupation:
    """A section that a train runs through between two instants; or a place in which it stays."""
    slices = (Slice(OccupationPart.RUN, from_s, to_s),)
    if stays:
        slices = (Slice(OccupationPart.APPROACH, from_s, to_s), Slice(OccupationPart.LAYOVER, to_s, to_s))
    direction = Direction.DOWN if down else Direction.UP
    return Occupation(section, train, train, direction, slices, from_s, math.inf if stays else to_s)
