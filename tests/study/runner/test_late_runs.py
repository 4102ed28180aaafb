"""Late days as they run: what is drawn happens to the train that it names, and nothing else changes."""

from pathlib import Path

import pytest

from scenario.scenario import load_scenario
from simulation.events import CameLate, DoorsHeld
from simulation.result import StopRecord
from study.measures.day_figures import day_figures
from study.record.figure import rows_in
from study.record.wait import Cause, Wait
from study.runner.run import CarrierKind, FinishedRun, PartyLink, execute
from tests.conftest import turn_back_in

FIXED = 'source = "made for tests"\nseconds = { distribution = "fixed", mean_s = 90.0 }\n'
ENTRY = f"[late.entry.a]\n{FIXED}".replace("90.0", "400.0")
DWELL = f"[late.dwell.a]\n{FIXED}"
DOORS = f"[late.doors.a]\nshare = 1.0\n{FIXED}"
ZONE = (
    "[late.dead_zones.a]\nper_day = 60.0\nlength_low_m = 500.0\nlength_high_m = 3000.0\n"
    'source = "made for tests"\nseconds = { distribution = "fixed", mean_s = 300.0 }\n'
)


def run(scenario: str, text: str = "", seed: int = 1) -> FinishedRun:
    """The turn-back scenario with more tables."""
    file = Path(scenario).with_name(f"late_{abs(hash(text))}.toml")
    file.write_text('extends = "turn_back"\nid = "late"\nname = "A late turn"\n' + text, "utf-8")
    return execute(load_scenario(str(file), seed), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)


def waits(run: FinishedRun) -> tuple[Wait, ...]:
    return tuple(rows_in(Wait, run.tables.waits))


def stop(of: FinishedRun, number: str, station: str) -> StopRecord:
    return next(s for s in of.result.stops if (s.number, s.station_id) == (number, station))


def late_s(of: FinishedRun, number: str, station: str) -> float:
    found = stop(of, number, station)
    assert found.departure_s is not None and found.planned_departure_s is not None
    return found.departure_s - found.planned_departure_s


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, FinishedRun]:
    file = turn_back_in(tmp_path_factory.mktemp("late"))
    off = "".join(part.replace("]\n", "]\non = false\n", 1) for part in (ENTRY, DWELL, DOORS, ZONE))
    texts = {"plain": "", "off": off, "entry": ENTRY, "dwell": DWELL, "doors": DOORS, "zone": ZONE}
    return {name: run(file, text) for name, text in texts.items()}


def test_a_day_without_sources_is_the_plain_day(runs: dict[str, FinishedRun]) -> None:
    assert runs["off"].result.digest == runs["plain"].result.digest
    assert runs["off"].result.motion_digest == runs["plain"].result.motion_digest
    digests = {run.result.motion_digest for name, run in runs.items() if name != "off"}
    assert len(digests) >= len(runs) - 2  # each source makes another day; dead zones may cost nothing
    assert runs["plain"].summary["late"]["drawn"] == []


def test_a_train_that_comes_late_leaves_late_by_what_its_wait_does_not_take_up(
    runs: dict[str, FinishedRun],
) -> None:
    late, plain = runs["entry"], runs["plain"]
    lead_s = late.scenario.setup.operation.portal_lead_s
    gained_s = late_s(late, "1D", "HSK") - late_s(plain, "1D", "HSK")
    assert 400.0 - lead_s - 30.0 < gained_s < 400.0
    (came,) = (e.event for e in late.result.journal.entries if isinstance(e.event, CameLate))
    assert (came.train, came.late_s) == ("1D", 400.0)
    figures = day_figures(late.result, late.scenario.setup)
    assert figures.primary_s >= 0.9 * gained_s and figures.secondary_s == 0.0
    (wait,) = (wait for wait in waits(late) if wait.cause is Cause.LATE)
    assert wait.to_s - wait.from_s == pytest.approx(400.0, abs=0.1)
    assert not [wait for wait in waits(plain) if wait.cause is Cause.LATE]


def test_passengers_hold_a_train_from_its_arrival_and_doors_from_its_departure(
    runs: dict[str, FinishedRun],
) -> None:
    dwell, doors, plain = (stop(runs[name], "1D", "SHN") for name in ("dwell", "doors", "plain"))
    assert dwell.arrival_s is not None and dwell.departure_s is not None
    assert 110.0 <= dwell.departure_s - dwell.arrival_s < 115.0  # 20 s of the timetable, 90 s drawn
    assert plain.departure_s is not None and doors.departure_s is not None
    assert doors.departure_s >= (doors.planned_departure_s or 0.0) + 90.0
    assert plain.departure_s < (plain.planned_departure_s or 0.0) + 5.0
    held = [e.event for e in runs["dwell"].result.journal.entries if isinstance(e.event, DoorsHeld)]
    assert {(one.train, one.station) for one in held} <= {("1D", "SHN"), ("2U", "OGN")}
    boards = [w for w in waits(runs["dwell"]) if w.cause is Cause.DWELL]
    assert any(wait.until_s == held[0].until_s and wait.to_s - wait.from_s > 40.0 for wait in boards)


def test_everyone_arrives_and_nothing_is_broken(runs: dict[str, FinishedRun]) -> None:
    for name, of in runs.items():
        assert of.broken == (), name
    lost = [e for e in runs["zone"].result.journal.entries if "no_coverage" in repr(e.event).lower()]
    assert lost and len(runs["zone"].result.courses) > 30


def test_another_seed_is_another_day(runs: dict[str, FinishedRun]) -> None:
    late = runs["zone"].summary["late"]
    other = execute(
        load_scenario(runs["zone"].scenario.file, 2), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN
    )
    assert other.summary["late"]["drawn"] != late["drawn"]
    assert len(late["drawn"]) == sum(late["counts"].values())


@pytest.mark.parametrize(
    ("carrier", "link"),
    [
        (CarrierKind.SUMO, PartyLink.SIMULATED),
        pytest.param(CarrierKind.PLAIN, PartyLink.ZENOH, marks=pytest.mark.nightly),
    ],
)
def test_the_same_seed_is_the_same_day_on_every_carrier_and_link(
    runs: dict[str, FinishedRun], carrier: CarrierKind, link: PartyLink
) -> None:
    """Doors are held by the world, dead zones by the air, whoever carries trains and telegrams."""
    folder = Path(runs["zone"].scenario.file).parent
    file = folder / "late_all.toml"
    head = 'extends = "turn_back"\nid = "late"\nname = "A late turn"\n'
    file.write_text(head + ENTRY + DWELL + DOORS + ZONE, "utf-8")
    plain = execute(load_scenario(str(file), 1), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)
    other = execute(load_scenario(str(file), 1), link, carrier=carrier)
    assert other.summary["late"]["drawn"] == plain.summary["late"]["drawn"] != []
    assert other.result.digest == plain.result.digest
