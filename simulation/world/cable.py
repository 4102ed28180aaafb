"""Invariant: with a central interlocking nothing is said that does not go over the cable, and nothing goes over a cut.

A centre (CTC) joins the line at one station; its cable runs from there along the line both ways, to the terminals and
to what stands for lineside signals and track circuits, the radio that trains hear (assumed: line files have neither).
The block manager stands in the centre. So a telegram between a unit and the manager goes along the cable between
the centre and the train, one between a unit and a terminal also from the centre to the terminal, however near the
two may be. Beyond a cut, seen from the centre, nobody is reached; where the whole cable is cut nobody is at all.

With relay interlockings (`relay`) each station can be worked from its own panel. Nobody is there: staff come
`staff_reach_s` after a cut. From then on what the centre does not reach is set by them, and a train's request for a
route counts once two stations have agreed on it by telephone, `telephone_block_s` after it was first made.

With interlocking on board nothing of it goes over a cable: units, manager and terminals have their radio, and a cut
takes nothing away. What else a line's cable may carry (telephones, level crossings, the supply) is not modelled.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from network.model import Line
from simulation.faults.cable import BETWEEN, WHOLE, CableCut
from simulation.settings import Interlocking, Operation
from wayside.config import MANAGER_ID

ANOTHER_S: Final = (
    10.0  # a unit repeats what was not answered within less: what comes later is another request
)


def centre_of(line: Line, operation: Operation) -> str:
    """The station at which the centre's cable joins the line; where none is named, the lowest."""
    return operation.centre or min(line.stations.values(), key=lambda station: station.position_m).id


class Cable:
    """The cable of one run, whole as it begins; its places are kilometrages, m."""

    def __init__(self, line: Line, operation: Operation) -> None:
        self.central: Final = operation.interlocking is not Interlocking.ONBOARD
        self._operation: Final = operation
        self._since_s = math.inf
        self._asked_s: dict[
            str, tuple[float, float]
        ] = {}  # by unit: its request, first and last made to staff
        self._station_m: Final = {station.id: station.position_m for station in line.stations.values()}
        self._centre_m: Final = self._station_m[centre_of(line, operation)]
        self._device_m: Final = {MANAGER_ID: self._centre_m, **_terminals_m(line)}
        self._cuts: tuple[CableCut, ...] = ()

    def cut(self, cuts: Sequence[CableCut], t_s: float = 0.0) -> None:
        """From now on the cable is cut there, and nowhere else."""
        self._since_s = min(self._since_s, t_s) if cuts else math.inf
        self._cuts = tuple(cuts)

    def worked_locally(self, t_s: float, unit_id: str, *, asks_route: bool) -> bool:
        """Whether staff at the stations see to what the centre does not reach, as a unit says it, or is told."""
        staffed_s = self._since_s + self._operation.staff_reach_s
        if self._operation.interlocking is not Interlocking.RELAY or t_s < staffed_s:
            return False
        if not asks_route:
            return True
        first_s, last_s = self._asked_s.get(unit_id, (t_s, t_s))
        first_s = t_s if t_s - last_s > ANOTHER_S else first_s
        self._asked_s[unit_id] = first_s, t_s
        return t_s - first_s >= self._operation.telephone_block_s

    @property
    def severed(self) -> bool:
        """Whether anybody may be out of the centre's reach."""
        return self.central and bool(self._cuts)

    def carries(self, unit_m: float, device_id: str) -> bool:
        """Whether a telegram between a unit that stands there and a device gets through."""
        return not self.severed or (self._reaches(unit_m) and self._reaches(self._device_m[device_id]))

    def _reaches(self, place_m: float) -> bool:
        return not any(self._severed(cut, place_m) for cut in self._cuts)

    def _severed(self, cut: CableCut, place_m: float) -> bool:
        if cut.stretch == WHOLE:
            return True
        low, high = (self._station_m[station] for station in cut.stretch.split(BETWEEN))
        cut_m = low + cut.along_share * (high - low)
        return place_m > cut_m if cut_m >= self._centre_m else place_m < cut_m


def _terminals_m(line: Line) -> dict[str, float]:
    """Where each terminal stands: amid its points."""
    pieces_m: dict[str, list[float]] = {}
    for points in line.points.values():
        stem = line.pieces[points.stem_piece]
        pieces_m.setdefault(points.terminal_id, []).append(0.5 * (stem.from_m + stem.to_m))
    return {terminal_id: sum(places_m) / len(places_m) for terminal_id, places_m in pieces_m.items()}
