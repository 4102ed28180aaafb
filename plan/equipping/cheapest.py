"""Every choice of options, the cheapest first: its least interval, and what nothing cheaper reaches.

That equipment only helps is nowhere assumed: no choice is left out because another one is worse.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any, Final

import msgspec

from network.errors import COMMAND_LINE, InputError
from network.files.toml_input import one_of
from plan.equipping.options import EquipmentOption, loops_to_lay, options_of, tables_of
from plan.least_interval import AS_UNITS_ASK, LeastInterval, least_interval, pattern_of, recounted
from plan.moving.proof import Impossibility
from plan.moving.refutation import TooManyCasesError
from simulation.setup import Setup
from study.capacity.rules import Rules

CHOICES_MAX: Final = 5000
WithTables = Callable[[Mapping[str, Any]], Setup]


@dataclass(frozen=True, slots=True)
class EquipmentChoice:
    """Options had together, and what they cost."""

    options: tuple[EquipmentOption, ...]
    cost: float

    @property
    def names(self) -> tuple[str, ...]:
        """Their names, in order."""
        return tuple(one.name for one in self.options)


@dataclass(frozen=True, slots=True)
class EquippedLine:
    """A choice and the least interval with it; `why_not` where the line cannot have it or nothing runs."""

    choice: EquipmentChoice
    setup: Setup | None
    found: LeastInterval | None
    why_not: str = ""

    @property
    def interval_s(self) -> float:
        """The least interval, s; infinite where there is none."""
        return float("inf") if self.found is None or self.found.interval_s is None else self.found.interval_s


class CheaperChoice(msgspec.Struct, frozen=True):
    """A cheaper choice: that it is too slow is proven, or it cannot be had."""

    options: tuple[str, ...]
    cost: float
    why_not: str
    proof: Impossibility | None


class CheapestProof(msgspec.Struct, frozen=True):
    """Why nothing cheaper than a cost has an interval of so many s or less: every choice that is."""

    cost: float
    interval_s: int
    cheaper: tuple[CheaperChoice, ...]


@dataclass(frozen=True, slots=True)
class EquipmentAsked:
    """What may be had: at most so many loops at these halts, the user's own options, all but those without which.

    `costs`: others than assumed, by name; `loop` is that of any loop.
    """

    loops: int = 1
    own: tuple[EquipmentOption, ...] = ()
    without: frozenset[str] = frozenset()
    costs: Mapping[str, float] = field(default_factory=dict[str, float])

    def costing(self, one: EquipmentOption) -> EquipmentOption:
        """The option at what the user says that it costs."""
        cost = self.costs.get("loop", one.cost) if one.loop else one.cost
        return replace(one, cost=self.costs.get(one.name, cost))


def choices_of(with_tables: WithTables, asked: EquipmentAsked) -> list[EquipmentChoice]:
    """All that can be had together, the cheapest first. Raises InputError for too many, or a name that is unknown."""
    line = with_tables({}).line
    loops = [asked.costing(one) for one in loops_to_lay(line) if not asked.without & {one.name, "loop"}]
    names = ["loop", *(one.name for one in (*loops_to_lay(line), *options_of(with_tables({})), *asked.own))]
    for one in asked.own:
        if names.count(one.name) > 1:
            raise InputError(COMMAND_LINE, "--options, name", one.name, "a name that no other option has")
    needs = [name for one in asked.own for name in one.needs]
    for key, asked_for in ("--cost, --without", (*asked.costs, *asked.without)), ("--options, needs", needs):
        for name in asked_for:
            if name not in names:
                raise InputError(COMMAND_LINE, key, name, one_of(sorted(names), name))
    found: list[EquipmentChoice] = []
    for count in range(asked.loops + 1):
        for laid in combinations(loops, count):
            try:
                others = list(options_of(with_tables(tables_of(laid))))
            except InputError:
                others = []  # there is no room for these loops: said where the choice is worked out
            others = [asked.costing(one) for one in (*others, *asked.own) if one.name not in asked.without]
            for together in _subsets(others):
                found.append(EquipmentChoice((*laid, *together), sum(o.cost for o in (*laid, *together))))
            if len(found) > CHOICES_MAX:
                raise InputError(
                    COMMAND_LINE, "--loops", asked.loops, f"no more than {CHOICES_MAX} choices: --without"
                )
    return sorted(found, key=lambda choice: (choice.cost, len(choice.options), choice.names))


def _subsets(options: Sequence[EquipmentOption]) -> Iterator[tuple[EquipmentOption, ...]]:
    for count in range(len(options) + 1):
        for together in combinations(options, count):
            names = {one.name for one in together}
            if all(set(one.needs) <= names for one in together):
                yield together


def equipped(with_tables: WithTables, choice: EquipmentChoice, rules: Rules = AS_UNITS_ASK) -> EquippedLine:
    """The least interval of a line with a choice."""
    try:
        setup = with_tables(tables_of(choice.options))
        return EquippedLine(choice, setup, least_interval(setup, rules))
    except TooManyCasesError:
        raise
    except InputError as error:
        return EquippedLine(choice, None, None, str(error))


def worked_out(
    with_tables: WithTables, choices: Sequence[EquipmentChoice], until_s: float = 0.0
) -> list[EquippedLine]:
    """The choices in order of cost, up to the first with an interval of no more than `until_s`."""
    found: list[EquippedLine] = []
    for choice in choices:
        found.append(equipped(with_tables, choice))
        if found[-1].interval_s <= until_s:
            break
    return found


def curve_of(found: Sequence[EquippedLine]) -> list[EquippedLine]:
    """Those that are quicker than all that cost no more: nothing cheaper, or as cheap, has their interval."""
    points: list[EquippedLine] = []
    for one in sorted(found, key=lambda one: (one.choice.cost, one.interval_s, one.choice.names)):
        if one.interval_s < (points[-1].interval_s if points else float("inf")):
            points.append(one)
    return points


def proof_of(found: Sequence[EquippedLine], interval_s: int) -> CheapestProof:
    """Why nothing cheaper than the last of these has that interval."""
    cost = found[-1].choice.cost
    cheaper = tuple(
        CheaperChoice(
            one.choice.names, one.choice.cost, one.why_not, None if one.found is None else one.found.proof
        )
        for one in found
        if one.choice.cost < cost
    )
    return CheapestProof(cost, interval_s, cheaper)


def objections_to(
    with_tables: WithTables, choices: Sequence[EquipmentChoice], proof: CheapestProof
) -> Iterator[str]:
    """What is wrong with such a proof: each cheaper choice must be there, and its own proof hold for the interval."""
    shown = {one.options: one for one in proof.cheaper}
    for choice in choices:
        if choice.cost >= proof.cost:
            continue
        name = " ".join(choice.names) or "nothing"
        one = shown.get(choice.names)
        try:
            setup = with_tables(tables_of(choice.options))
            pattern_of(setup, AS_UNITS_ASK)
        except InputError:
            continue  # it cannot be had, or nothing runs from end to end
        if one is None or one.proof is None:
            yield f"{name} costs {choice.cost:g} and is not excluded"
            continue
        yield from (f"{name}: {wrong}" for wrong in recounted(setup, AS_UNITS_ASK, one.proof))
        excluded = {
            s for e in one.proof.excluded for s in range(e.from_ticks, (e.to_ticks or proof.interval_s) + 1)
        }
        if not set(range(1, proof.interval_s + 1)) <= excluded:
            yield f"{name}: not every interval up to {proof.interval_s} s is excluded"
