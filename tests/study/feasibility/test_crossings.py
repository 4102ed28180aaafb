"""What `check` says of level crossings, by hand: 12.5 m/s all along the test line."""

from pathlib import Path

import pytest

from exchange.new_line import NewLineOptions, write_line
from network.clock import clock
from network.making.sample_day import write_sample
from scenario.scenario import load_scenario
from study.feasibility.check import feasibility
from study.feasibility.finding import Finding, FindingKind, Severity
from tests.trains import timetable_of

HEAD = """extends = "rtri_test_line"
id = "crossed"
name = "With a crossing"
[[patch.line.add.crossings]]
id = "C1"
section = "6"
km = 0.803
"""


def found(folder: Path, *keys: str, before: str = "") -> list[Finding]:
    """Findings about a road whose edge lies at 0.8 km for down trains, with these keys."""
    file = folder / "crossed.toml"
    file.write_text("\n".join((HEAD.replace("[[patch", f"{before}\n[[patch", 1), *keys)), encoding="utf-8")
    findings = feasibility(load_scenario(str(file)).setup).findings
    return [finding for finding in findings if finding.kind is FindingKind.LEVEL_CROSSING]


def test_one_by_radio_under_radio_is_well(tmp_path: Path) -> None:
    assert found(tmp_path) == []


@pytest.mark.parametrize(
    ("start_km", "severity", "short_s"),
    [
        (0.5, Severity.IMPOSSIBLE, 1.0),  # 300 m at 12.5 m/s: 24 s, where 25 s are the least
        (0.4875, None, None),  # 25 s
    ],
)
def test_contacts_lie_far_enough_out_for_the_fastest_train(
    tmp_path: Path, start_km: float, severity: Severity | None, short_s: float | None
) -> None:
    contacts = ('control = "contacts"', f"start_down_km = {start_km}", "start_up_km = 1.3")
    findings = found(tmp_path, *contacts)
    assert [finding.severity for finding in findings] == ([] if severity is None else [severity])
    if severity is not None:
        assert findings[0].short_s == pytest.approx(short_s, abs=0.01)
        assert findings[0].trains == ("T1",)
        assert "for 24 s" in findings[0].text


def test_more_than_a_minute_is_reported(tmp_path: Path) -> None:
    (finding,) = found(tmp_path, "closed_s = 46.0")
    assert (finding.severity, finding.text) == (Severity.TIGHT, "level crossing C1 warns for 61 s")


def test_units_need_radio_where_they_ask(tmp_path: Path) -> None:
    """41 s at 12.5 m/s are 512.5 m: it is asked from 0.29 km on, before T1's path begins at 0.36 km."""
    parts = "{ from_km = 0.0, to_km = 0.6 }, { from_km = 0.9, to_km = 1.41 }"
    dead = f'patch.line.set = {{ "alignments.main.coverage" = [{parts}] }}'
    (finding,) = found(tmp_path, before=dead)
    assert finding.severity is Severity.TIGHT
    assert "does not reach at km 0.6" in finding.text
    assert "513 m before it" in finding.remedy


@pytest.mark.parametrize(("more_s", "severity"), [(0, Severity.LATE), (240, Severity.TIGHT)])
def test_without_radio_all_the_way_the_stop_makes_late_who_has_no_time_for_it(
    tmp_path: Path, more_s: int, severity: Severity
) -> None:
    """A minute for leave and two to brake, creep over and gain speed: T1 has less of it to spare, or four minutes."""
    timetable = load_scenario("rtri_test_line").setup.timetable
    arrives_s = (timetable.trains["T1"].calls[-1].arrival_s or 0) + more_s
    later = f'patch.timetable.set = {{ "trains.T1.calls.B.arrival" = "{clock(arrives_s)}" }}'
    dead = 'patch.line.set = { "alignments.main.coverage" = [{ from_km = 0.9, to_km = 1.41 }] }'
    (finding,) = found(tmp_path, "closed_s = 20.0", "closing_s = 10.0", before=f"{dead}\n{later}")
    assert finding.severity is severity
    assert ("which makes them late by" in finding.remedy) == (severity is Severity.LATE)


@pytest.mark.parametrize(("sight_m", "wrong"), [(112.0, True), (113.0, False)])
def test_without_a_device_its_users_see_what_comes_while_they_cross(
    tmp_path: Path, sight_m: float, wrong: bool
) -> None:
    """6 m at 1 m/s and 3 s: 9 s at 12.5 m/s are 112.5 m."""
    assert bool(found(tmp_path, 'kind = "4"', f"sight_m = {sight_m}")) is wrong


@pytest.mark.parametrize("starts_km", [0.40, 0.46])
def test_who_begins_beyond_the_first_contact_is_not_warned_of(tmp_path: Path, starts_km: float) -> None:
    """T1 begins with its front at km 0.44: it never passes a contact at km 0.40, but one at km 0.46, 27 s before."""
    findings = found(tmp_path, 'control = "contacts"', f"start_down_km = {starts_km}", "start_up_km = 1.3")
    if starts_km > 0.44:
        assert findings == []
        return
    (finding,) = findings
    assert (finding.severity, finding.trains, finding.short_s) == (Severity.IMPOSSIBLE, ("T1",), 25.0)
    assert finding.text == (
        "level crossing C1 does not warn of down trains that begin in 3, beyond its first contact"
    )


def test_with_departures_it_is_warned_of_where_the_radio_reaches(tmp_path: Path) -> None:
    """T1 begins at km 0.44; where it does not, its unit asks too late."""
    own = ('control = "contacts"', "start_down_km = 0.40", "start_up_km = 1.3", "departures = true")
    assert found(tmp_path, *own) == []
    parts = "{ from_km = 0.0, to_km = 0.6 }, { from_km = 0.9, to_km = 1.41 }"
    (finding,) = found(
        tmp_path, *own, before=f'patch.line.set = {{ "alignments.main.coverage" = [{parts}] }}'
    )
    assert "does not reach at km 0.6" in finding.text


def test_who_turns_beyond_the_first_contact_is_not_warned_of(tmp_path: Path) -> None:
    """T2 goes back from B, where the contact of up trains lies behind it."""
    turning = 'timetable = "rtri_turn_back"'
    own = ('control = "contacts"', "start_down_km = 0.46", "start_up_km = 1.2")
    (finding,) = found(tmp_path, *own, before=turning)
    assert (finding.severity, finding.trains) == (Severity.IMPOSSIBLE, ("T2",))
    assert "up trains that begin in 8" in finding.text


TIMES = timetable_of(
    "two_numbers",
    "karasuyama",
    "D1 down, stabled to becomes:D2: HSK 1 -/10:00:00; OGN 1 10:20:00/-",
    "D2 down, from:D1 to stabled: OGN 1 -/10:25:00; KRS 1 10:40:00/-",
    dwell_min_s=30,
    K1="D1 D2",
)


@pytest.mark.parametrize(("km", "section", "unwarned"), [(12.7, "OGN.1", ()), (12.85, "OGN-KRS", ("D2",))])
def test_who_goes_on_as_another_train_has_passed_a_contact_of_its_way(
    tmp_path: Path, km: float, section: str, unwarned: tuple[str, ...]
) -> None:
    """D2 begins at OGN at km 12.62. The crossing on that track lies on the way of D1, who passed its contact; the next
    one does not.
    """
    (tmp_path / "two_numbers.toml").write_text(TIMES, encoding="utf-8")
    (tmp_path / "day.toml").write_text(
        f"""extends = "karasuyama_weekday"
id = "two_numbers_day"
name = "two numbers"
timetable = "two_numbers.toml"
[[patch.line.add.crossings]]
id = "C1"
section = "{section}"
km = {km}
control = "contacts"
start_down_km = 12.0
start_up_km = {km + 0.7}
""",
        encoding="utf-8",
    )
    findings = feasibility(load_scenario(str(tmp_path / "day.toml")).setup).findings
    silent = [finding.trains for finding in findings if "does not warn" in finding.text]
    assert silent == ([unwarned] if unwarned else [])


@pytest.mark.parametrize("speed_kmh", [60, 85, 130])
def test_the_radio_of_a_line_made_from_a_list_reaches_where_its_crossings_are_asked(
    tmp_path: Path, speed_kmh: int
) -> None:
    """Halfway between two stations 12 km apart, of which the radio alone reaches 1.5 km."""
    (tmp_path / "st.csv").write_text("name,km,tracks\nA,0,2\nB,12,2\n", "utf-8")
    (tmp_path / "roads.csv").write_text("km,id,kind\n5.9,X1,1\n6.3,X2,3\n9.0,X3,4\n", "utf-8")
    options = NewLineOptions(max_speed_kmh=float(speed_kmh), crossings=tmp_path / "roads.csv")
    made = write_line(tmp_path / "st.csv", tmp_path / "made.toml", options)
    write_sample(made.line, tmp_path / "made.toml", tmp_path / "day.toml")
    setup = load_scenario(str(tmp_path / "day.toml")).setup
    assert [finding.text for finding in feasibility(setup).findings] == []
    coverage = next(iter(made.line.alignments.values())).coverage
    assert not any(one.from_m < 9000.0 < one.to_m for one in coverage), "without a device it asks nobody"
