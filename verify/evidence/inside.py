"""Whether a run lies inside what was explored: whenever a party has acted, each view of two units and a section."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from network.model import Line
from onboard.authority.records import RequestKind
from onboard.plan import NO_PLAN
from verify.evidence.watched import PartyState
from verify.pair_view import (
    GroundState,
    OwnView,
    PairView,
    Powered,
    kind_of,
    needed_in,
    own_view,
    pair_view,
)
from wayside.config import MANAGER_ID
from wayside.point_terminal import Terminal
from wayside.register import Register

NOBODY: Final = ""  # beside a unit that is alone on its line


class FirstSeen(NamedTuple):
    """Where in a run a view was seen first: after so many lines of the journal, the party that acted, of whom."""

    run: str
    line: int
    who: str
    unit: str
    other: str
    section: str


@dataclass(slots=True)
class InsideFigures:
    """`events`: a party has acted; `without`: of them, on nothing that has a section; `beyond`: of them, with any view
    that no explored state has; `states`: views looked at.
    """

    events: int = 0
    without: int = 0
    beyond: int = 0
    states: int = 0
    distinct: set[PairView] = field(default_factory=set[PairView])
    outside: Counter[PairView] = field(default_factory=Counter[PairView])
    first: dict[PairView, FirstSeen] = field(default_factory=dict[PairView, FirstSeen])


class PairWatch:
    """Looks at the parties of one run; `lines` counts those of its journal."""

    def __init__(self, views: frozenset[PairView], line: Line, run: str, figures: InsideFigures) -> None:
        with_points = {points.section_id for points in line.points.values()}
        self.figures: Final = figures
        self.lines = 0
        self._run: Final = run
        self._views: Final = views
        self._kinds: Final = {
            s.id: kind_of(s.kind, points=s.id in with_points) for s in line.sections.values()
        }
        self._units: Final[dict[str, Powered | None]] = {}
        self._register: Register | None = None
        self._terminals: Final[dict[str, Terminal]] = {}
        self._own: Final[dict[tuple[str, str], OwnView]] = {}

    def look(self, party_id: str, state: PartyState) -> None:
        """A party has acted, or its power went."""
        match state:
            case Register():
                self._register = state
                self._units.update(dict.fromkeys(state.plan.unit_ids - self._units.keys()))
                about = sorted({(unit, section) for section, unit in state.holders.items()})
            case Terminal():
                self._terminals[party_id] = state
                about = self._of_terminal(state)
            case None if party_id == MANAGER_ID:
                self._register = None
                about = self._of_units()
            case None if party_id not in self._units:
                self._terminals.pop(party_id, None)
                about = self._of_units()
            case None:
                self._forget(party_id, None)
                about = self._of_unit(party_id)
            case _:
                self._forget(party_id, Powered(*state))
                about = self._of_unit(party_id)
        self._judge(party_id, about)

    def _forget(self, unit_id: str, now: Powered | None) -> None:
        self._units[unit_id] = now
        for key in [key for key in self._own if key[0] == unit_id]:
            del self._own[key]

    def _judge(self, party_id: str, about: list[tuple[str, str]]) -> None:
        figures, looked, beyond = self.figures, 0, False
        figures.events += 1
        for unit, section in about:
            for other, view in self._views_of(unit, section):
                looked += 1
                figures.distinct.add(view)
                if view not in self._views:
                    beyond = True
                    figures.outside[view] += 1
                    place = FirstSeen(self._run, self.lines, party_id, unit, other, section)
                    figures.first.setdefault(view, place)
        figures.states += looked
        figures.without += not looked
        figures.beyond += beyond

    def _of_unit(self, unit_id: str) -> list[tuple[str, str]]:
        """Sections that a unit has to do with."""
        unit = self._units[unit_id]
        holders = {} if self._register is None else dict(self._register.holders)
        sections = {section_id for section_id, holder in holders.items() if holder == unit_id}
        if unit is not None and unit.plan is not NO_PLAN:
            authority, place = unit.duty.authority, unit.duty.place
            request = authority.open(RequestKind.ROUTE)
            sections |= {*authority.held, *(request.section_ids or () if request else ())}
            spans = unit.plan.spans[max(0, place.clear - 1) : place.perhaps + 1] if place.known else ()
            sections |= {span.section_id for span in spans}
        return [(unit_id, section) for section in sorted(sections)]

    def _of_units(self) -> list[tuple[str, str]]:
        return [item for unit_id in self._units for item in self._of_unit(unit_id)]

    def _of_terminal(self, terminal: Terminal) -> list[tuple[str, str]]:
        locked = terminal.memory.commitments
        return sorted({(c.unit_id, terminal.views[p].entry.section_id) for p, c in locked.items()})

    def _views_of(self, unit: str, section: str) -> Iterator[tuple[str, PairView]]:
        """With each other unit, those alike once; a section that a third holds is looked at with that one."""
        own, kind = self._own_view(unit, section), self._kinds[section]
        needed = needed_in(self._units.get(unit), section)
        ground, seen = GroundState(self._register, self._terminals), set[PairView]()
        for other in [u for u in self._units if u != unit] or [NOBODY]:
            views = own, self._own_view(other, section)
            view = pair_view(kind, ground, section, (unit, other), views, needed)
            if view is not None and view not in seen:
                seen.add(view)
                yield other, view

    def _own_view(self, unit: str, section: str) -> OwnView:
        found = self._own.get((unit, section))
        if found is None:
            found = self._own[unit, section] = own_view(self._units.get(unit), section)
        return found
