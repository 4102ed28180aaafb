"""Scenarios and drills, each run once and held against what was explored."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Final

import msgspec

from network.code_store import CodeStore, kept_folder
from onboard.duty.records import DutyPhase
from onboard.duty_parameters import ReleaseRule
from scenario.scenario import Scenario, load_scenario
from simulation.events import JournalEntry
from simulation.journal import Journal
from simulation.result import RunResult
from study.drilling.drill import drills_in, find_drill, shipped_drills
from study.runner.outcome import broken_rules
from study.runner.run import CarrierKind, UnitsAt
from study.sweep.digest import digest_of
from verify.evidence.inside import FirstSeen, InsideFigures, PairWatch
from verify.evidence.watched import WatchedParties, result_of
from verify.explore import explored
from verify.explored_line import Budgets, ExploredLine
from verify.pair_set import views_of
from verify.pair_view import Believed, PairView
from verify.search import TOLD_EVERY, Level
from wayside.register import UnitStanding

# One trouble at a time; with trains that wait for their time, as trains of a timetable do.
LINES: Final = (
    ExploredLine(budgets=Budgets(loss=1, delay=1), timed=True),
    ExploredLine(budgets=Budgets(power=1)),
    ExploredLine(budgets=Budgets(points=1, sensor=1)),
    ExploredLine(budgets=Budgets(word=1)),
    ExploredLine(budgets=Budgets(word=1), bars=True),
    ExploredLine(budgets=Budgets(power=1), tag_between=ReleaseRule.ROUTE),
    ExploredLine(budgets=Budgets(power=1), tag_between=ReleaseRule.SECTION),
    ExploredLine(budgets=Budgets(loss=1), timed=True, tag_between=ReleaseRule.SECTION),
    ExploredLine(budgets=Budgets(set_back=1), timed=True),
)
BEGINS: Final = "a train signs on where it stands (explored trains come in by a portal)"
PASSES: Final = (
    "its unit is told that it is off the line and the boundary's contact is still to count, at one instant"
)
RECOVERS: Final = (
    "after more troubles than are explored at once (power, stores, words, bars, a position lost)"
)
# Standings that only troubles lead to. Who is reported, outside or leaving is so on any day: that excuses nothing.
IN_TROUBLE: Final = frozenset({UnitStanding.UNKNOWN, UnitStanding.BY_HAND, UnitStanding.DISPUTED})
_IN_IT: Final = {None: "does not know whether it is in it", True: "in it", False: "not in it"}
OTHER: Final = "no known lack of the model"
VIEWS: Final = CodeStore(kept_folder() / "views")
DECIDING: Final = (
    "network",
    "radio",
    "onboard",
    "wayside",
    "verify",
)  # what a state can be, and what is viewed


def explored_views(
    lines: Sequence[ExploredLine], watch: Callable[[str], None], store: CodeStore = VIEWS
) -> frozenset[PairView]:
    """Views that the states of these lines have, all explored whole, once for this code (decision 297).

    ValueError for a line that does not hold. `watch` takes what is being done, while it is.
    """
    views, code = set[PairView](), digest_of(*DECIDING)
    for number, line in enumerate(lines, start=1):
        name = f"exploring line {number} of {len(lines)}, once for this code ({'/'.join(map(str, line.budgets))})"

        def made(line: ExploredLine = line, name: str = name) -> bytes:
            watch(name)
            return msgspec.msgpack.encode(list(_explored_views(line, lambda text: watch(f"{name}: {text}"))))

        kept = store.made("views", (code, line), made)
        views.update(msgspec.msgpack.decode(kept, type=list[PairView]))
    return frozenset(views)


def _explored_views(line: ExploredLine, watch: Callable[[str], None]) -> frozenset[PairView]:
    def tell(level: Level) -> None:
        if level.depth % TOLD_EVERY == 0:
            watch(f"level {level.depth}, {level.distinct} states")

    found = explored(line, watch=tell)
    if not found.holds:
        raise ValueError(f"{line} does not hold")
    return views_of(found)


def runs_named(names: Iterable[str]) -> tuple[str, ...]:
    """Scenarios, drills, and all drills of a folder."""
    return tuple(one for name in names for one in (drills_in(name) if name else ()))


def is_by_authority(scenario: Scenario) -> bool:
    """Whether its trains run under authority alone: where people work the line past it, nothing of it is explored."""
    return scenario.setup.substitute is None and scenario.setup.line_signals is None


def load(name: str, seed: int | None = None) -> Scenario:
    """A scenario or a drill."""
    return load_scenario(find_drill(name) if name in shipped_drills() else name, seed)


def watched_run(scenario: Scenario, views: frozenset[PairView], figures: InsideFigures) -> RunResult:
    """Run it on plain track, and look at its parties whenever one has acted."""
    watch = PairWatch(views, scenario.setup.line, scenario.id, figures)

    def count(_entry: JournalEntry) -> None:
        watch.lines += 1

    def journal() -> Journal:
        made = Journal()
        made.watch(count)
        return made

    # units as parties, so that they can be looked at; in this process all the same
    return result_of(
        scenario,
        CarrierKind.PLAIN,
        UnitsAt.PROCESSES,
        lambda parties: WatchedParties(parties, watch.look),
        journal,
    )


def broken_in(scenario: Scenario, result: RunResult) -> tuple[str, ...]:
    """Rules that a run broke, in words; none of a drill that lets persons who are wrong break some, and judges them."""
    judged = any(expectation.rules for expectation in scenario.setup.script.expectations)
    return () if judged else tuple(f"{scenario.id}: {text}" for _, text in broken_rules(result))


def lacking(view: PairView) -> str:
    """What the model lacks, as far as is known, for a view that no explored state has."""
    own, ground = view.own, view.ground
    if own.phase is DutyPhase.SIGNING_ON and own.holds:
        return BEGINS
    if own.phase is DutyPhase.GONE and ground.standing is UnitStanding.LEAVING:
        return PASSES
    lost = own.phase in (None, DutyPhase.OFF, DutyPhase.ON_SIGHT, DutyPhase.SIGNING_ON)
    unsaid = not ground.defined or not {ground.standing, ground.others_standing}.isdisjoint(IN_TROUBLE)
    if lost or unsaid or view.other.within is None or own.believed is Believed.UNKNOWN:
        return RECOVERS
    return OTHER


def by_lack(figures: InsideFigures) -> Counter[str]:
    """Views outside, counted by what the model lacks for them."""
    count = Counter[str]()
    for view, times in figures.outside.items():
        count[lacking(view)] += times
    return count


def first_without(figures: InsideFigures) -> tuple[PairView, FirstSeen] | None:
    """The first view outside for which no lack of the model is known, and where it was seen; None: there is none."""
    return next(((view, at) for view, at in figures.first.items() if lacking(view) == OTHER), None)


def view_words(view: PairView) -> str:
    """A view in words."""
    own, other, ground = view.own, view.other, view.ground
    said = [
        f"{view.kind.value} section: a unit {'without power' if own.phase is None else own.phase.value}",
        own.believed.value,
        *(word for word, so in (("holds it", own.holds), ("asks for it", own.asks)) if so),
        *(["has its points proven"] if own.proven else []),
        f"another {_IN_IT[other.within]}",
        *(["holds it too"] if other.holds else []),
    ]
    holder = "the unit's" if ground.held else "the other's" if ground.held_by_other else "free"
    standing = "none" if ground.standing is None else ground.standing.value
    said += [
        f"in the register it is {holder}, the unit {standing}",
        "defined" if ground.defined else "undefined",
    ]
    return ", ".join(said)
