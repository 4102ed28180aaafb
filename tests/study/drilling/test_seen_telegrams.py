"""What the grid of telegrams leaves out is the run of an instant that it has, or of none of its faults."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from hashlib import blake2b
from itertools import chain
from typing import Any

import numpy as np
import pytest

from radio.noted import Lost, LostWhere, Sent, TookEffect
from scenario.scenario import Scenario, load_scenario
from simulation.events import FaultBegan, FaultOver, JournalEntry
from simulation.faults.fault import Fault
from simulation.faults.links import DeadZone, FaultyLink, LinkFault
from simulation.faults.script import Script
from simulation.result import RunResult
from simulation.setup import STEPS_PER_S, Setup
from study.drilling import every_instant, telegram_grid
from study.drilling.drill import find_drill
from study.drilling.every_instant import InstantWindow, Variation, sweep
from study.drilling.moving import staffed
from study.drilling.outcome_class import OutcomeKind, SweptRun
from study.drilling.seen_telegrams import SeenTelegram, TelegramWatch
from study.drilling.telegram_grid import FaultChoice, grid_of
from tests.nightly import others_nightly


def entry(t_s: float, event: Any) -> JournalEntry:  # noqa: ANN401
    return JournalEntry(t_s, "world", event)


def terms(source: str, receiver: str, sequence: int, kind: str) -> dict[str, Any]:
    return {
        "source": source,
        "receiver": receiver,
        "epoch": 1,
        "sequence": sequence,
        "kind": kind,
        "correlation": 0,
    }


def test_what_is_said_again_in_vain_is_a_repeat_until_somebody_is_heard() -> None:
    watch = TelegramWatch({"K1": ("up", 120.0)}.get)

    def said(t_s: float, sequence: int, kind: str, *, lost: bool, receiver: str = "m") -> None:
        about = terms("K1", receiver, sequence, kind)
        watch.see(entry(t_s, Sent(size_bytes=9, arrives_s=(t_s + 0.1,), **about)))
        if lost:
            watch.see(entry(t_s + 0.1, Lost(where=LostWhere.RECEIVER_OFF, **about)))
        else:
            watch.see(entry(t_s + 0.1, TookEffect(**about)))

    said(1.0, 1, "Ask", lost=True)
    said(2.0, 2, "Ask", lost=True)  # a repeat
    said(3.0, 3, "Claim", lost=True)  # another thing,
    said(4.0, 4, "Ask", lost=True, receiver="t")  # to another
    said(5.0, 5, "Ask", lost=True)  # a repeat
    said(6.0, 6, "Ask", lost=False)  # heard
    said(7.0, 7, "Ask", lost=True)  # so it is new
    seen = watch.telegrams()
    sent = [each for each in seen if each.is_sent]
    assert [each.is_repeat for each in sent] == [False, True, False, False, True, False, False]
    assert [each.is_lost for each in sent] == [True, True, True, True, True, False, True]
    assert [(each.step, each.party) for each in seen if not each.is_sent] == [(61, "m")]
    assert {each.place for each in sent} == {("up", 120.0)}


def by_all_of_both_ends(fault: Fault[Any], _setup: Setup) -> Callable[[SeenTelegram], bool]:
    """The grid without what it leaves out."""
    if isinstance(fault, LinkFault):
        return lambda seen: fault.target.joins(seen.source, seen.receiver)
    return lambda _seen: True


def noted(result: RunResult, script: Script) -> SweptRun:
    """What happened, but for notes of the fault itself and of telegrams on their way; when its links were used.

    Not the trace: it has a row where a stretch ends, and a fault that begins ends one.
    """
    own = (FaultBegan, FaultOver, Sent, Lost)
    digest = blake2b(repr((result.stops, result.end_step, result.violations)).encode())
    for each in result.journal.entries:
        if not isinstance(each.event, own):
            digest.update(repr(each).encode())
    sent = [each for each in result.journal.entries if isinstance(each.event, Sent)]
    target = script.faults[0].fault.target
    steps = (
        round(each.t_s * STEPS_PER_S)
        for each in sent
        if isinstance(each.event, Sent)
        and (not isinstance(target, FaultyLink) or target.joins(each.event.source, each.event.receiver))
    )
    return SweptRun(OutcomeKind.LATE, " ".join(map(str, steps)), digest=digest.hexdigest())


def twin_of(step: int, kept: Iterable[int], sends: Iterable[int]) -> int | None:
    """The kept instant from which on the same telegrams meet the fault first."""
    for other in sorted(kept, key=lambda each: abs(each - step)):
        if not any(min(step, other) < sent <= max(step, other) for sent in sends):
            return other
    return None


def variations(scenario: Scenario, of: Callable[[Variation], bool]) -> list[Variation]:
    grid = grid_of(scenario.setup, FaultChoice.ALL, InstantWindow())
    return [variation for variation in grid.variations if of(variation)]


PAIRS_OF = [
    ("rtri/12_terminal_power", 12),
    ("rtri/14c_manager_and_units_one_each", 40),
    ("rtri/02_turn_back", 200),
]


@pytest.mark.parametrize(("name", "pairs"), others_nightly(PAIRS_OF, PAIRS_OF[:1], columns=True))
def test_a_fault_of_links_is_that_of_the_kept_instant_from_which_it_meets_the_same_telegrams(
    name: str, pairs: int, monkeypatch: pytest.MonkeyPatch, record_property: Callable[[str, object], None]
) -> None:
    scenario = staffed(load_scenario(find_drill(name)))
    kept = {
        v.name: v for v in variations(scenario, lambda v: v.faults[0][1].fault.kind in ("cut", DeadZone.kind))
    }
    seen = telegram_grid._course(scenario.setup).telegrams
    concerns = {n: telegram_grid._concerns(v.faults[0][1].fault, scenario.setup) for n, v in kept.items()}
    monkeypatch.setattr(telegram_grid, "_concerns", by_all_of_both_ends)
    full = {v.name: v for v in variations(scenario, lambda v: v.name in kept)}
    left_out = [
        (n, step)
        for n, v in full.items()
        for step in v.instants or ()
        if step not in (kept[n].instants or ())
    ]
    assert len(left_out) > pairs
    claimed: list[tuple[str, int, int]] = []
    for i in np.random.default_rng(22).choice(len(left_out), pairs, replace=False):
        n, step = left_out[i]
        sends = [each.step for each in seen if concerns[n](each)]
        other = twin_of(step, kept[n].instants or (), sends)
        if other is not None:
            claimed.append((n, step, other))
    wanted: dict[str, set[int]] = {}
    for n, *steps in claimed:
        wanted.setdefault(n, set()).update(steps)
    monkeypatch.setattr(every_instant, "swept_run_of", noted)
    moved = [replace(kept[n], instants=tuple(sorted(steps))) for n, steps in wanted.items()]
    runs = sweep(scenario.setup, moved, InstantWindow(), 1, None, scenario.setup.script).outcomes
    same = differ = apart = 0
    for n, step, other in claimed:
        if not runs[n].keys() >= {step, other}:
            continue  # after the last train
        lasts = round((kept[n].faults[0][1].duration_s or 0.0) * STEPS_PER_S)
        ends = sorted((step + lasts, other + lasts))
        used = chain(*(map(int, runs[n][each].label.split()) for each in (step, other)))
        if any(ends[0] <= sent <= ends[1] for sent in used):
            apart += 1
        elif runs[n][step].digest == runs[n][other].digest:
            same += 1
        else:
            differ += 1
    record_property(
        "figures", f"{name}: {same} same, {differ} differ, {apart} with a telegram between their ends"
    )
    assert not differ, (name, same, differ, apart)
    assert same
