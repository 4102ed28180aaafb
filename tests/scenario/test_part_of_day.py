"""A part of a day: every set begins where the plan has it, and what is run is what the whole day has there."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from network.errors import InputError
from network.timetable import AtPortal, parse_timetable
from scenario.inputs import read_inputs
from scenario.part_of_day import beginnings, part_of_day
from scenario.scenario import load_scenario
from simulation.result import Ending
from study.drilling.drill import find_drill
from study.runner.run import CarrierKind, PartyLink, execute
from tests.plain import run_on_plain
from tests.trains import timetable_of

HOUR_S = 3600

# B comes to the track at Ogane that A left five minutes before; both are there, or on their way from it, at eight.
FOLLOWING = timetable_of(
    "following",
    "karasuyama",
    "2A up, stabled to stabled: OGN 2 -/07:50; HSK 08:12/-",
    "4B up, stabled to portal:HSK.MD: KRS -/07:30; OGN 2 07:55/08:05; HSK 08:27/-",
    A="2A",
    B="4B",
)


def begun_at(scenario: str, begins: str) -> dict[str, tuple[str, str | None, bool]]:
    """Of each set: its first train, the first station, and whether it comes by a portal."""
    timetable = part_of_day(load_scenario(scenario), begins, None).setup.timetable
    first = {diagram.stock_id: timetable.trains[diagram.train_numbers[0]] for diagram in timetable.diagrams}
    return {
        stock_id: (train.number, train.calls[0].station_id, isinstance(train.begins, AtPortal))
        for stock_id, train in first.items()
    }


def test_every_set_begins_where_the_plan_has_it_last() -> None:
    """By the published timetable: at 7:00 the meet at Ogane is just over; V1 and V4 are on the main line.

    At 8:05 326M has left Ogane and V4 turns at Karasuyama; the other two are outside.
    """
    assert begun_at("karasuyama_weekday", "07:00") == {
        "V1": ("327M", "HSK", True),
        "V2": ("324M", "OGN", False),
        "V3": ("323M", "OGN", False),
        "V4": ("325M", "HSK", True),
    }
    assert begun_at("karasuyama_weekday", "08:05") == {
        "V1": ("327M", "HSK", True),
        "V2": ("329M", "HSK", True),
        "V3": ("326M", "OGN", False),
        "V4": ("328M", "KRS", False),
    }


def test_a_set_whose_trains_are_over_is_not_there() -> None:
    assert set(begun_at("karasuyama_weekday", "21:15")) < {"V1", "V2", "V3", "V4"}


def test_all_that_follows_is_as_planned() -> None:
    whole = load_scenario("karasuyama_weekday").setup.timetable
    part = part_of_day(load_scenario("karasuyama_weekday"), "08:05", None).setup.timetable
    late = {number for number, train in whole.trains.items() if train.calls[-1].last_s > 8 * HOUR_S + 300}
    assert set(part.trains) == late
    cut = {number for number in late if part.trains[number] != whole.trains[number]}
    assert cut == {"326M", "328M"}
    assert part.trains["326M"].calls[1:] == whole.trains["326M"].calls[-len(part.trains["326M"].calls) + 1 :]


def test_a_set_begins_earlier_where_another_has_used_its_track(monkeypatch: pytest.MonkeyPatch) -> None:
    line = load_scenario("karasuyama_weekday").setup.line
    timetable = parse_timetable(FOLLOWING, "following.toml", line)
    begun = beginnings(line, timetable, 8 * HOUR_S)
    assert (begun["A"].call, begun["B"].call) == (0, 0)

    def nobody(*_: object) -> None:
        """The rule, switched off."""

    monkeypatch.setattr("scenario.part_of_day._in_the_way", nobody)
    both = beginnings(line, timetable, 8 * HOUR_S)
    assert both["A"].section_id == both["B"].section_id  # two sets on one track, without that rule


# After midnight without its day, which follows from what is before.
NIGHT = timetable_of(
    "night",
    "karasuyama",
    "2A up, stabled to becomes:1A: KRS -/23:30; OGN 2 23:52/00:05; HSK 00:27/-",
    "1A down, from:2A to stabled: HSK -/00:40; KRS 01:20/-",
    A="2A 1A",
)


def test_a_train_is_on_its_day_without_what_is_before_midnight(tmp_path: Path) -> None:
    """Begun at 23:58 or 24:38, or without its first train: 00:05 is 24:05, and 00:40 is 24:40."""
    (tmp_path / "night.toml").write_text(NIGHT, "utf-8")
    head = 'extends = "karasuyama_weekday"\nid = "s"\nname = "Night"\ntimetable = "night.toml"\n'
    (tmp_path / "s.toml").write_text(head, "utf-8")

    def begins_s(begins: str | None, patch: dict[str, Any] | None = None) -> int:
        tables = {} if patch is None else {"patch": {"timetable": patch}}
        part = part_of_day(load_scenario(str(tmp_path / "s.toml"), tables=tables), begins, None)
        timetable = part.setup.timetable
        return timetable.trains[timetable.diagrams[-1].train_numbers[0]].calls[0].first_s

    assert begins_s("23:58") == 24 * HOUR_S + 5 * 60
    assert begins_s("24:38") == 24 * HOUR_S + 40 * 60
    alone = {"remove": {"trains": ["2A"]}, "set": {"trains.1A.begins": "stabled"}}
    assert begins_s(None, alone) == 24 * HOUR_S + 40 * 60
    like = {"number": "9", "train": "1A", "later_s": 600, "stock": "Z", "begins": "stabled"}
    assert begins_s(None, {"like": [like]}) == 24 * HOUR_S + 50 * 60


@pytest.mark.parametrize(
    ("begins", "until", "said"),
    [
        ("25:00", None, "--from is '25:00'; expected a time before 23:33:00"),
        ("8", None, "--from is '8'; expected a time HH:MM"),
        (None, "04:00", "--until is '04:00'; expected a time after 05:37:00"),
        ("10:00", "09:00", "--until is '09:00'; expected a time after 10:00:00"),
    ],
)
def test_a_time_of_which_nothing_can_be_run_is_refused(
    main: Callable[..., Any], begins: str | None, until: str | None, said: str
) -> None:
    options = [word for pair in (("--from", begins), ("--until", until)) if pair[1] for word in pair]
    ended = main("run", "karasuyama_weekday", *options)
    assert ended.code == 2 and ended.out == ""
    assert ended.err.startswith(f"error: command line: {said}") and ended.err.count("\n") == 1


def test_faults_have_the_whole_day(tmp_path: Path) -> None:
    file = tmp_path / "off.toml"
    fault = '[[fault]]\nkind = "power_off"\ntarget = "V1"\nstart = "10:00"\n'
    file.write_text(f'extends = "karasuyama_weekday"\nid = "off"\nname = "Off"\n{fault}', "utf-8")
    with pytest.raises(InputError, match="a scenario without faults and acts"):
        part_of_day(load_scenario(str(file)), "08:00", None)
    assert part_of_day(load_scenario(str(file)), None, "08:00").setup.script.faults


def test_people_at_line_signals_have_the_whole_day() -> None:
    """Whoever acted before it begins would act as it begins."""
    drill = load_scenario(find_drill("shigaraki/01_as_it_was"))
    with pytest.raises(InputError, match="a scenario without faults and acts"):
        part_of_day(drill, "10:25", None)


def test_what_runs_until_then_is_what_the_whole_day_has_until_then(turn_back: str) -> None:
    whole = run_on_plain(turn_back)
    part = run_on_plain(part_of_day(load_scenario(turn_back), None, "05:50"))
    assert part.result.ended_because is Ending.PART_OVER and part.broken == ()
    end_s = part.summary["latest_end_s"]
    assert end_s == 5 * HOUR_S + 50 * 60 == part.result.end_step / 10
    early = [entry for entry in whole.result.journal.entries if entry.t_s < end_s]
    assert [entry for entry in part.result.journal.entries if entry.t_s < end_s] == early
    assert len(early) > 50
    stops = part.tables.stops
    assert stops["arrival_s"].drop_nulls().max() < end_s
    there = whole.tables.stops.filter(pl.col("arrival_s") < end_s)
    assert stops.filter(pl.col("arrival_s") < end_s).equals(there) and there.height == 2


def test_a_part_runs_from_where_the_plan_has_all(main: Callable[..., Any], tmp_path: Path) -> None:
    """On SUMO: one is under way at 8:05, one turns; both arrive in time, and the run says where they began."""
    ended = main(
        "run", "karasuyama_weekday", "--from", "08:05", "--until", "09:00", "--out", "part", "--json"
    )
    summary = ended.figures()
    assert ended.code == 0
    assert (summary["trains_planned"], summary["trains_arrived"], summary["invariants_broken"]) == (2, 2, 0)
    assert abs(summary["late_s_max"]) < 10.0
    assert summary["simulated_s"] < 1.5 * HOUR_S
    assert (tmp_path / "part" / "report.html").exists()
    said = read_inputs(tmp_path / "part" / "inputs.json").assumed[-1]
    assert "V3 as 326M at OGN on track 2, 07:52:00; V4 as 328M at KRS on track 1, 08:26:00" in said


def test_the_plain_carrier_runs_the_same_part(turn_back: str) -> None:
    part = part_of_day(load_scenario(turn_back), "06:00", None)
    runs = [
        execute(part, PartyLink.SIMULATED, carrier=kind) for kind in (CarrierKind.SUMO, CarrierKind.PLAIN)
    ]
    assert runs[0].result.digest == runs[1].result.digest
    assert runs[0].summary["trains_arrived"] == runs[0].summary["trains_planned"] == 1
