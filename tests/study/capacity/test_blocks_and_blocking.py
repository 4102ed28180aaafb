"""The tables `blocks` and `blocking` of one run say the same, and what the journal says."""

import math

import pytest

from network.model import SectionKind
from onboard.notes import MissionBegun
from scenario.scenario import load_scenario, shipped_scenarios
from simulation.events import Entered
from study.capacity.blocking_table import read_blocking
from study.drilling.drill import find_drill
from study.measures import register_holds
from study.measures.visits import SectionVisit
from study.runner.run import FinishedRun
from tests.plain import run_on_plain
from wayside import said

NEAR_S = 0.11  # a step, and rounding


def differences(run: FinishedRun) -> list[str]:
    """What the two tables say otherwise of a section that a unit had, and portals entered at another time or train."""
    ends_s = run.result.end_step / 10.0
    rows = sorted(run.tables.blocks.iter_rows(named=True), key=lambda r: (r["section"], r["granted_s"]))
    had = sorted(read_blocking(run.tables.blocking), key=lambda o: (o.section_id, o.begin_s))
    found = [f"{len(rows)} and {len(had)} rows"] if len(rows) != len(had) else []
    for row, one in zip(rows, had, strict=False):
        name = f"{row['section']} {row['unit']}"
        if (one.section_id, one.stock_id, one.number) != (row["section"], row["unit"], row["train"]):
            found.append(f"{name}: {row['train']}, {one.stock_id} {one.number}")
        entered_s = math.inf if row["entered_s"] is None else row["entered_s"]
        if one.enters_s > -math.inf and abs(min(entered_s, 1e9) - min(one.enters_s, 1e9)) > NEAR_S:
            found.append(f"{name}: entered {entered_s}, {one.enters_s}")
        released_s = ends_s if row["released_s"] is None else row["released_s"]
        if abs(released_s - one.end_s) > NEAR_S:
            found.append(f"{name}: released {released_s}, {one.end_s}")
        if not one.begin_s - NEAR_S <= row["granted_s"] <= one.end_s + NEAR_S:
            found.append(f"{name}: granted {row['granted_s']}, {one.begin_s} to {one.end_s}")
    return [*found, *_against_the_journal(run), *_misnamed(run)]


def _misnamed(run: FinishedRun) -> list[str]:
    """Sections had by another train than the one that the unit had taken up, by its own word in the journal."""
    found: list[str] = []
    for row in run.tables.blocks.iter_rows(named=True):
        begun = [
            e.event.train
            for e in run.result.journal.entries
            if e.who == row["unit"] and isinstance(e.event, MissionBegun) and e.t_s <= row["granted_s"]
        ]
        if begun and row["train"] != begun[-1]:
            found.append(f"{row['section']} {row['unit']}: {row['train']}, and not {begun[-1]}")
    return found


def _against_the_journal(run: FinishedRun) -> list[str]:
    """A stock that comes in is in its portal from the moment at which it came, as the train that it has taken up."""
    entries = run.result.journal.entries
    sections = run.scenario.setup.line.sections
    portals = [s.id for s in sections.values() if s.kind is SectionKind.PORTAL]
    rows = [r for r in run.tables.blocks.iter_rows(named=True) if r["section"] in portals]
    found: list[str] = []
    for entry in entries:
        if not isinstance(entry.event, Entered):
            continue
        unit = entry.event.unit_id
        taken = (e.event for e in entries if e.t_s >= entry.t_s and isinstance(e.event, said.Accepted))
        first = next((e for e in taken if e.unit_id == unit), None)
        if first is None or not set(first.section_ids) & set(portals):
            continue  # it stood on a track as the day began
        train = entry.event.train
        own = [r for r in rows if r["unit"] == unit and r["entered_s"] is not None]
        if not any(abs(r["entered_s"] - entry.t_s) <= NEAR_S and r["train"] == train for r in own):
            found.append(f"{unit} came in at {entry.t_s} as {train}: {own}")
    return found


@pytest.fixture(scope="module")
def ran() -> FinishedRun:
    return run_on_plain("rtri_test_line")


def test_the_paper_s_run_has_one_occupation(ran: FinishedRun) -> None:
    assert differences(ran) == []


@pytest.mark.parametrize("drill", ["rtri/03_block_held", "rtri/09_manager_power", "rtri/20_route_given_back"])
def test_a_drill_has_one_occupation(drill: str) -> None:
    scenario = load_scenario(str(find_drill(drill)))
    assert differences(run_on_plain(scenario)) == []


@pytest.mark.nightly
@pytest.mark.parametrize("name", shipped_scenarios())
def test_a_shipped_day_has_one_occupation(name: str) -> None:
    assert differences(run_on_plain(name)) == []


def test_a_train_named_by_where_it_was_seen_last_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two trains of one set, the second from a portal: named by what was seen before, it bears the first one's name."""
    scenario = load_scenario(str(find_drill("rtri/03_block_held")))
    number = register_holds._number
    names: list[str] = []

    def seen_last(hold: register_holds.SectionHold, visits: list[SectionVisit]) -> str:
        names.append(number(hold, visits))
        return names[-2] if len(names) > 1 else ""

    monkeypatch.setattr(register_holds, "_number", seen_last)
    assert differences(run_on_plain(scenario))
