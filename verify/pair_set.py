"""All views of two units and one section (`verify.pair_view`) that explored states have."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np

from network.model import SectionKind
from onboard.duty.records import DutyState
from verify.expansion import TERMINAL_BITS
from verify.explore import ExploredSpace
from verify.explored_line import TERMINALS, manager_config
from verify.pair_view import (
    GroundState,
    OwnView,
    PairView,
    Powered,
    kind_of,
    needed_in,
    own_view,
    pair_view,
    without_points,
)
from verify.parties import ExploredParties, Numbered
from verify.tables import Numbers

NO_WAY: Final = -1
_KINDS: Final = {"P": SectionKind.PORTAL, "X": SectionKind.POINTS}


def views_of(found: ExploredSpace) -> frozenset[PairView]:
    """Every view that a state of an explored line has."""
    return _Views(found).all()


class _Views:
    def __init__(self, found: ExploredSpace) -> None:
        self._parties: Final[ExploredParties] = found.parties
        columns = found.expansion.columns(found.space.states)
        # What is viewed of a train does not depend on what is on the air, and so on.
        self._trains: Final = tuple(
            np.array([key[0] for key in cells.keys.things], np.int64)[numbers]
            for cells, numbers in zip(found.expansion.cells, columns.cells, strict=True)
        )
        self._columns: Final = columns
        self._grounds: Final = dict[int, GroundState]()

    def all(self) -> frozenset[PairView]:
        views = {
            view
            for section_id in (s.section_id for s in manager_config(self._parties.line).sections)
            for own, other in ((0, 1), (1, 0))
            for view in self._of(section_id, own, other)
        }
        return frozenset(views | {without_points(view) for view in views})

    def _of(self, section_id: str, own: int, other: int) -> set[PairView]:
        """Of each state: what is viewed of both trains, and of the ground; put together once for each three of them."""
        seen: tuple[Numbered[tuple[OwnView, int]], ...] = tuple(Numbered() for _ in (own, other))
        trains = tuple(
            _by_number(self._trains[unit], partial(self._train, seen[i], unit, section_id))
            for i, unit in enumerate((own, other))
        )
        manager, one, two = self._columns.manager, *self._columns.terminals
        ground = manager << 2 * TERMINAL_BITS | one << TERMINAL_BITS | two
        known, ground = np.unique(ground, return_inverse=True)
        codes = np.unique((ground * len(seen[1].things) + trains[1]) * len(seen[0].things) + trains[0])
        kind = kind_of(_KINDS.get(section_id, SectionKind.TRACK), points=section_id == "X")
        units = self._parties.units[own], self._parties.units[other]
        views, of_own, of_other = set[PairView](), seen[0].things, seen[1].things
        for code in map(int, codes):
            rest, mine = divmod(code, len(of_own))
            at, theirs = divmod(rest, len(of_other))
            (own_, way), (other_, _) = of_own[mine], of_other[theirs]
            needed = needed_in(self._on_plan(own, way), section_id)
            view = pair_view(kind, self._ground(int(known[at])), section_id, units, (own_, other_), needed)
            assert view is not None, "no third unit is explored"
            views.add(view)
        return views

    def _train(self, seen: Numbered[tuple[OwnView, int]], unit: int, section_id: str, train: int) -> int:
        """What is viewed of a train, with its plan where it needs points; NO_WAY: it needs none."""
        state = self._parties.trains[unit].things[train]
        plan = self._parties.train_models[unit].plan(state)
        view = own_view(Powered(plan, state.duty) if state.power else None, section_id)
        return seen.number((view, state.plan if view.proven else NO_WAY))

    def _on_plan(self, unit: int, way: int) -> Powered | None:
        plans = self._parties.train_models[unit].plans
        return None if way == NO_WAY else Powered(plans[way], DutyState())

    def _ground(self, code: int) -> GroundState:
        found = self._grounds.get(code)
        if found is None:
            parties, mask = self._parties, (1 << TERMINAL_BITS) - 1
            manager, numbers = code >> 2 * TERMINAL_BITS, (code >> TERMINAL_BITS & mask, code & mask)
            states = [parties.terminals[i].things[n] for i, n in enumerate(numbers)]
            register = parties.managers.things[manager]
            found = self._grounds[code] = GroundState(
                register.kept.register if register.power else None,
                {t: s.kept.terminal for t, s in zip(TERMINALS, states, strict=True) if s.power},
            )
        return found


def _by_number(numbers: Numbers, value: Callable[[int], int]) -> Numbers:
    """A value for each state, worked out once for each number."""
    known, where = np.unique(numbers, return_inverse=True)
    return np.array([value(int(n)) for n in known], np.int64)[where]
