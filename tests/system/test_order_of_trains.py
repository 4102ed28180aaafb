"""The order of trains in runs of a line: kept below its threshold, changed above, and nobody waits by it for ever.

Two trains meet on the busy line: A is planned first over the open line, from the west; B waits for it at the loop.
What makes A late is its radio: it cannot ask.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import pytest

from scenario.scenario import load_scenario
from study.runner.outcome import unfinished
from study.runner.run import CarrierKind, FinishedRun, PartyLink, execute
from tests.trains import day_of
from wayside.said import HeldBack, OrderChanged

DUE_S: Final = {"A": 36_000.0, "B": 36_480.0}  # 10:00 and 10:08

TRAINS: Final = """
[timetable]
id = "meet"
name = "Trains that meet at a loop"
line = "busy_line"
dwell_min_s = 30
assumed = ["all times: six minutes from station to station"]
"""
SILENT: Final = (
    '[[fault]]\nkind = "cut"\ntarget = "SA <-> block-manager"\nstart = "09:55"\nduration_s = {lasts_s:.1f}\n'
)
FOR_GOOD: Final = '[[fault]]\nkind = "cut"\ntarget = "SA <-> block-manager"\nstart = "09:55"\n'
SILENT_FROM_S: Final = 35_700.0


@dataclass(frozen=True)
class Day:
    """A run: when trains left, and what the journal has of their order."""

    run: FinishedRun

    def left_s(self, number: str) -> float | None:
        return next(s.departure_s for s in self.run.result.stops if s.number == number)

    @property
    def held(self) -> list[str]:
        return [e.event.why for e in self.run.result.journal.entries if isinstance(e.event, HeldBack)]

    @property
    def changed(self) -> list[str]:
        return [e.event.why for e in self.run.result.journal.entries if isinstance(e.event, OrderChanged)]


def train(number: str, way: str, track: str, to: str, departure: str, arrival: str) -> str:
    here, there = way.split(" ")
    direction = "down" if here == "ASA" else "up"
    calls = f"{here} {track} -/{departure}; {there} {to} {arrival}/-"
    return day_of(f"{number} {direction}, stabled to stabled: {calls}", **{f"S{number}": number})


A: Final = train("A", "ASA IZU", "1", "1", "10:00", "10:06")
B: Final = train("B", "IZU ASA", "2", "2", "10:08", "10:14")


def day(
    folder: Path,
    dispatch: str,
    faults: str,
    trains: str = A + B,
    link: PartyLink = PartyLink.SIMULATED,
) -> Day:
    """The day, with the trains and faults given."""
    (folder / "meet.toml").write_text(TRAINS + trains, encoding="utf-8")
    file = folder / "day.toml"
    head = 'extends = "busy_line"\nid = "day"\nname = "A meet"\ntimetable = "meet.toml"\n'
    limits = "[limits]\ntime_limit_s = 1800.0\n"
    file.write_text(head + limits + f"[dispatch]\n{dispatch}\n" + faults, encoding="utf-8")
    return Day(execute(load_scenario(str(file)), link, carrier=CarrierKind.PLAIN))


def late(minutes: float) -> str:
    """A is heard again so late after its departure."""
    return SILENT.format(lasts_s=DUE_S["A"] - SILENT_FROM_S + 60.0 * minutes)


@pytest.mark.parametrize("order", ["planned", "least_delay"])
def test_the_planned_order_is_kept_below_the_threshold(tmp_path: Path, order: str) -> None:
    kept = day(tmp_path, f'order = "{order}"\nkeep_order_below_min = 12.0', late(9.0))
    a_s, b_s = kept.left_s("A"), kept.left_s("B")
    assert a_s is not None and b_s is not None and a_s < b_s
    assert kept.changed == []
    assert kept.held and all(why.startswith("B waits for A, planned first; it is ") for why in kept.held)
    assert unfinished(kept.run.result) == ()


def test_above_it_who_asks_first_goes(tmp_path: Path) -> None:
    changed = day(tmp_path, 'order = "planned"\nkeep_order_below_min = 2.0', late(9.0))
    a_s, b_s = changed.left_s("A"), changed.left_s("B")
    assert a_s is not None and b_s is not None and b_s < DUE_S["B"] + 10.0 < a_s
    (why,) = changed.changed
    assert why.startswith("order changed: B goes before A, planned first; it is ")
    assert unfinished(changed.run.result) == ()


@pytest.mark.nightly
def test_the_order_of_least_delay_is_the_same_on_both_links(tmp_path: Path) -> None:
    """A solver's process of its own stands beside either manager."""
    days = [
        day(tmp_path, 'order = "optimal"\nkeep_order_below_min = 2.0', late(9.0), link=link)
        for link in (PartyLink.SIMULATED, PartyLink.ZENOH)
    ]
    here, apart = (done.run.summary["digest"] for done in days)
    assert here == apart
    reasons = [*days[0].held, *days[0].changed]
    assert reasons and reasons == [*days[1].held, *days[1].changed]
    assert any("late in all in the best order" in why for why in reasons)


def test_without_a_rule_nothing_is_held_or_told(tmp_path: Path) -> None:
    free = day(tmp_path, "", late(9.0))
    b_s = free.left_s("B")
    assert b_s is not None and b_s < DUE_S["B"] + 10.0
    assert (free.held, free.changed) == ([], [])


def test_nobody_waits_for_ever_for_a_train_that_cannot_leave(tmp_path: Path) -> None:
    rule = 'order = "planned"\nkeep_order_below_min = 60.0\nhold_min_max = 5.0'
    waited = day(tmp_path, rule, FOR_GOOD)
    b_s = waited.left_s("B")
    assert b_s is not None and 0.0 <= b_s - (DUE_S["B"] + 300.0) < 30.0
    assert waited.changed == ["order changed: B has waited 5 min for A, the most it may"]
    assert unfinished(waited.run.result)[0] == "1 train did not arrive: A"


# A goes on, C comes after it; B asked, saw A go before it, and is not heard when A has come.
GOES_ON: Final = day_of("A down, stabled to stabled: ASA 1 -/10:00; IZU 1 10:06/10:07; USU 1 10:13/-", SA="A")
C: Final = train("C", "ASA IZU", "2", "1", "10:16", "10:22")
B_SILENT: Final = (
    '[[fault]]\nkind = "cut"\ntarget = "SB <-> block-manager"\nstart = "10:10"\nduration_s = 720.0\n'
)


@pytest.mark.parametrize(("overtaken_max", "waits"), [(1, True), (5, False)])
def test_who_was_overtaken_too_often_goes_next(tmp_path: Path, overtaken_max: int, waits: bool) -> None:
    rule = f'order = "planned"\nkeep_order_below_min = 1.0\novertaken_max = {overtaken_max}'
    to_one = train("B", "IZU ASA", "2", "1", "10:08", "10:14")  # the track that A leaves
    run = day(tmp_path, rule, late(9.0) + B_SILENT, GOES_ON + to_one + C)
    b_s, c_s = run.left_s("B"), run.left_s("C")
    assert b_s is not None and c_s is not None
    assert (b_s < c_s) is waits
    assert ("C waits for B, before which 1 train has gone" in run.held) is waits
    assert unfinished(run.run.result) == ()
