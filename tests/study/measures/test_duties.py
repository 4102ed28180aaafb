"""What each set runs over the day, from the plan and from a run."""

import json
from dataclasses import replace

import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Line
from network.timetable import Call, Stabled, Timetable, load_timetable
from study.measures.duties import SetDuty, duties_of


def planned(name: str = "karasuyama_weekday", line_name: str = "karasuyama") -> tuple[Line, Timetable]:
    line = load_line(shipped_line(line_name))
    return line, load_timetable(shipped_timetable(name), line)


def of(duties: tuple[SetDuty, ...], stock_id: str) -> SetDuty:
    return next(duty for duty in duties if duty.stock_id == stock_id)


def test_the_sets_of_a_weekday() -> None:
    line, timetable = planned()
    duties = duties_of(line, timetable)
    assert [duty.stock_id for duty in duties] == ["V1", "V2", "V3", "V4"]
    whole_m = line.stations["KRS"].position_m - line.stations["HSK"].position_m
    v3 = of(duties, "V3")
    assert [t.number for t in v3.trains] == ["323M", "326M", "331M", "334M", "345M", "E346M"]
    assert v3.distance_m == pytest.approx(6 * whole_m)
    assert v3.empty_m == pytest.approx(whole_m)
    # 345M arrives at 22:05 and goes back empty at 22:15: nothing turns faster
    assert v3.turn_min_s == 600
    assert v3.on_duty_s == (22 * 60 + 48) * 60 - (6 * 60 + 36) * 60
    kinds = [(gap.kind, gap.station_id, gap.length_s) for gap in v3.gaps]
    assert kinds[0] == ("outside", "HSK", None)
    assert kinds[1] == ("turn", "KRS", 22 * 60)
    assert kinds[2][0] == "outside"
    v1 = of(duties, "V1")
    assert (v1.gaps[0].kind, v1.gaps[-1].kind) == ("stabled", "stabled")


@pytest.mark.parametrize(
    ("name", "line"),
    [("karasuyama_weekday", "karasuyama"), ("karasuyama_holiday", "karasuyama"), ("busy_line", "busy_line")],
)
def test_every_train_is_in_one_duty_and_time_goes_on(name: str, line: str) -> None:
    plan = planned(name, line)
    duties = duties_of(*plan)
    ran = [train.number for duty in duties for train in duty.trains]
    assert sorted(ran) == sorted(plan[1].trains)
    for duty in duties:
        assert len(duty.gaps) == len(duty.trains) + 1
        ends = [time_s for train in duty.trains for time_s in (train.begins_s, train.ends_s)]
        assert ends == sorted(ends)
        between = sum(gap.length_s or 0 for gap in duty.gaps)
        assert duty.running_s + between == duty.on_duty_s


def test_as_run_has_the_true_times_and_what_did_not_run() -> None:
    line, timetable = planned()

    def late(call: Call) -> Call:
        arrival_s = None if call.arrival_s is None else call.arrival_s + 90
        return replace(call, arrival_s=arrival_s)

    ran = [
        replace(train, calls=tuple(late(call) for call in train.calls))
        for train in timetable.trains.values()
        if train.number != "E346M"
    ]
    v3 = of(duties_of(line, timetable, ran), "V3")
    assert v3.missing == ("E346M",)
    assert [train.late_s for train in v3.trains] == [90] * 5
    assert v3.trains[0].ends_s - v3.trains[0].planned_ends_s == 90
    assert v3.turn_min_s == 17 * 60 - 90
    nothing = of(duties_of(line, timetable, []), "V1")
    assert (nothing.trains, nothing.gaps, nothing.distance_m, nothing.turn_min_s) == ((), (), 0, None)


def test_a_train_that_does_not_come_to_its_end_is_not_early_there_and_its_set_is_not_stabled() -> None:
    line, timetable = planned()
    ran = [
        replace(train, calls=train.calls[:3], ends=Stabled()) if train.number == "321M" else train
        for train in timetable.trains.values()
        if train.number != "324M"
    ]
    v2 = of(duties_of(line, timetable, ran), "V2")
    assert (v2.trains[0].number, v2.trains[0].late_s, v2.trains[0].cut_short) == ("321M", None, True)
    assert [train.cut_short for train in v2.trains[1:]] == [False] * (len(v2.trains) - 1)
    after = next(gap for gap in v2.gaps if gap.after == "321M")
    assert (after.kind, after.station_id) == ("cut short", timetable.trains["321M"].calls[2].station_id)


def test_it_is_json() -> None:
    duties = duties_of(*planned())
    tables = json.loads(json.dumps([duty.as_dict() for duty in duties]))
    assert tables[0]["trains"][0]["number"] == "322M"
    assert tables[0]["gaps"][1]["length_s"] == duties[0].gaps[1].length_s
