"""The one check: broken plans are refused for what was broken, good ones are not, and what lies between is told."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Direction, TagPurpose
from onboard.duty_parameters import ReleaseRule
from scenario.scenario import load_scenario, shipped_scenarios
from simulation.settings import Operation
from simulation.tolerance import CALLS_SHORT_M, OFF_MARK_M
from study.drilling.drill import find_drill
from study.feasibility.check import PlanRefusedError, feasibility, refuse
from study.feasibility.finding import FindingKind, Severity, length_of_time, minute, severity_of
from study.feasibility.planned import planned_day
from study.feasibility.rehearsal import Rehearsal
from study.measures.running_times import planned_legs
from tests.nightly import A_FIFTH, others_nightly
from tests.study.feasibility.broken_plans import BREAKS, STATIONS, TEN, Broken, good, journey
from tests.study.feasibility.good_plans import good_plan
from tests.study.feasibility.plans import Plan, call_at, later, with_call
from tests.system.test_passing import SCENARIO, times_of

NOT_TO_WORK = ("karasuyama_without_loop",)


# what is broken, and what is good ------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", BREAKS.values(), ids=BREAKS.keys())
def test_a_broken_plan_is_refused_for_what_was_broken(make: Callable[[], Broken]) -> None:
    broken = make()
    first = feasibility(broken.plan.setup()).not_as_printed[0]
    assert (first.kind, first.place, first.minute) == (broken.kind, broken.place, broken.minute)
    assert set(first.trains) == broken.trains
    assert all(number in first.text for number in first.trains[:1])
    assert first.remedy
    assert "\n" not in first.sentence


def test_the_plan_before_it_is_broken_is_good_and_shows_its_meets() -> None:
    found = feasibility(good().setup())
    assert found.findings == ()
    meets = [(m.down_train, m.up_train, m.station, m.down_track, m.up_track, m.possible) for m in found.meets]
    assert meets == [("D", "V", "EDO", "1", "2", True), ("W", "V", "IZU", "1", "2", True)]
    assert [minute(meet.time_s) for meet in found.meets] == ["10:23", "10:39"]


@pytest.mark.parametrize("plans", [10, pytest.param(200, marks=pytest.mark.nightly)])
def test_no_good_plan_is_refused(plans: int) -> None:
    refused: list[tuple[int, str]] = []
    meets = trains = 0
    for seed in range(plans):
        plan = good_plan(seed)
        found = feasibility(plan.setup())
        refused += [(seed, finding.sentence) for finding in found.not_as_printed]
        meets, trains = meets + len(found.meets), trains + len(plan.trains)
    assert refused == []
    assert trains > 3 * plans  # they are no empty days
    assert meets > plans // 2


@pytest.mark.parametrize(
    "name",
    others_nightly(shipped_scenarios(), ("busy_line", "karasuyama_weekday", "rtri_test_line", *NOT_TO_WORK)),
)
def test_what_is_shipped_is_good_unless_it_is_meant_not_to_work(name: str) -> None:
    found = feasibility(load_scenario(name).setup)
    assert found.good is (name not in NOT_TO_WORK), [f.sentence for f in found.not_as_printed]


@pytest.mark.parametrize("day", ["karasuyama_weekday", "karasuyama_holiday"])
def test_the_real_days_meet_ten_times_at_ogane(day: str) -> None:
    found = feasibility(load_scenario(day).setup)
    assert [meet.station for meet in found.meets] == ["OGN"] * 10
    assert all({meet.down_track, meet.up_track} == {"1", "2"} for meet in found.meets)


def test_without_the_loop_each_of_these_meets_is_impossible() -> None:
    wanted = feasibility(load_scenario("karasuyama_weekday").setup).meets
    found = feasibility(load_scenario("karasuyama_without_loop").setup)
    meets = [f for f in found.not_as_printed if f.kind is FindingKind.OPPOSING]
    assert [f.trains for f in meets] == [(m.down_train, m.up_train) for m in wanted]
    # the first never goes on
    assert [f.severity for f in meets] == [Severity.IMPOSSIBLE, *[Severity.LATE] * 9]
    assert [f.kind for f in found.impossible] == [FindingKind.OPPOSING, FindingKind.CIRCLE]
    assert not any(meet.possible for meet in found.meets)
    assert found.impossible[0].sentence == (
        "321M and 322M would meet at Ogane at 05:57: it has one track; no other station has two tracks"
    )


# the rule ------------------------------------------------------------------------------------------------------------


def test_whole_minutes_hide_up_to_59_seconds_and_seconds_up_to_29() -> None:
    assert severity_of(59.9, 600, 1200) is Severity.TIGHT
    assert severity_of(60.0, 600, 1200) is Severity.LATE
    assert severity_of(29.9, 600, 1215) is Severity.TIGHT
    assert severity_of(30.0, 600, 1215) is Severity.LATE
    assert severity_of(math.inf, 600) is Severity.IMPOSSIBLE


@given(st.floats(0.0, 600.0), st.floats(0.0, 600.0), st.lists(st.integers(0, 86_400)))
def test_what_is_shorter_is_not_less_severe(one_s: float, other_s: float, planned_s: list[int]) -> None:
    low, high = (severity_of(short_s, *planned_s) for short_s in sorted((one_s, other_s)))
    assert low is Severity.TIGHT or high is Severity.LATE


def test_a_leg_that_is_somewhat_short_is_told_and_not_refused() -> None:
    """Oka 100 s earlier: 320 s for what takes 344 s, in a plan with seconds; 150 s earlier it runs late."""
    plan = good()
    tight = feasibility(plan.with_train(later(plan.train("W"), -100, "OKA")).setup())
    assert [(f.kind, f.severity, f.place) for f in tight.findings] == [
        (FindingKind.LEG, Severity.TIGHT, "EDO-OKA")
    ]
    assert tight.good
    assert tight.findings[0].short_s == pytest.approx(24.0, abs=2.0)
    found = feasibility(plan.with_train(later(plan.train("W"), -150, "OKA")).setup())
    assert found.good
    assert found.verdict == "late: it runs, but not as printed; W would come to Oka at 11:01:44, 74 s late"


@A_FIFTH
@given(st.integers(-6 * 3600, 8 * 3600))
def test_the_same_plan_at_another_time_is_found_alike(by_s: int) -> None:
    whole_s = by_s // 60 * 60
    plan = BREAKS["one_track_for_both"]().plan
    moved = replace(plan, trains=tuple(later(train, whole_s) for train in plan.trains))
    now, then = (feasibility(each.setup()).not_as_printed for each in (plan, moved))
    assert len(now) == len(then) > 1
    for first, second in zip(now, then, strict=True):
        assert (first.kind, first.trains, first.place) == (second.kind, second.trains, second.place)
        assert second.time_s - first.time_s == whole_s


def test_unnamed_tracks_are_those_that_the_run_takes() -> None:
    """On the busy line track 1 is the usual one going down and track 2 going up; at the ends both are for both."""
    plan = good()
    unnamed = plan
    for train in plan.trains:
        calls = tuple(replace(call, track=None) for call in train.calls[1:-1])
        named = replace(train, calls=(train.calls[0], *calls, train.calls[-1]))
        unnamed = unnamed.with_train(named)
    found = feasibility(unnamed.setup())
    assert found.findings == ()
    assert [(m.down_track, m.up_track) for m in found.meets] == [("1", "2")] * 2
    both = unnamed.with_train(with_call(unnamed.train("W"), "KAS", track=None))
    assert [f.kind for f in feasibility(both.setup()).not_as_printed] == [
        FindingKind.TERMINAL,
        FindingKind.LATE,
    ]


def test_a_missing_arrival_is_that_of_a_train_without_delay() -> None:
    """Without arrivals the good plan stays good, and a leg that is too fast is found by its departures."""
    plan = good()

    def bare(plan: Plan) -> Plan:
        for train in plan.trains:
            middle = tuple(replace(call, arrival_s=None) for call in train.calls[1:-1])
            plan = plan.with_train(replace(train, calls=(train.calls[0], *middle, train.calls[-1])))
        return plan

    assert feasibility(bare(plan).setup()).findings == ()
    fast = bare(plan.with_train(later(plan.train("W"), -5 * 60, "OKA")))
    wrong = [(FindingKind.LEG, "EDO-OKA"), (FindingKind.LATE, "OKA")]
    assert [(f.kind, f.place) for f in feasibility(fast.setup()).not_as_printed] == wrong


@pytest.mark.parametrize(("passes", "place"), [("07:17:30", None), ("07:09", "OGN-KBN")])
def test_passing_and_standing_for_nobody_count(passes: str, place: str | None, tmp_path: Path) -> None:
    """1D runs through Ogane while 2U stands there for it; or eight minutes before 2U, and itself, can be there."""
    (tmp_path / "timetable.toml").write_text(times_of("07:00", "07:16", passes), "utf-8")
    (tmp_path / "day.toml").write_text(SCENARIO.replace("line.toml", "karasuyama"), "utf-8")
    found = feasibility(load_scenario(str(tmp_path / "day.toml")).setup)
    wrong = [(FindingKind.LEG, "HSK-OGN"), (FindingKind.OPPOSING, place)] if place else []
    assert [(f.kind, f.place) for f in found.not_as_printed] == wrong
    assert [meet.station for meet in found.meets] == [None if place else "OGN"]


def test_blocks_that_the_day_makes_up_for_are_tight() -> None:
    """W leaves Asahi behind D 30 s before the next section is free, with slack for more than that on the leg."""
    plan = good()
    behind = later(plan.train("W"), -32 * 60 + 6 * 60)
    behind = replace(behind, calls=tuple(replace(call, track="2") for call in behind.calls))
    calls = tuple(
        replace(c, arrival_s=(c.arrival_s or 0) + 60, departure_s=c.departure_s and c.departure_s + 60)
        for c in behind.calls[1:]
    )
    behind = replace(behind, calls=(behind.calls[0], *calls))
    alone = replace(plan, trains=(*(t for t in plan.trains if t.number in "DU"), behind))
    found = feasibility(alone.setup())
    assert found.good
    assert {(f.kind, f.severity) for f in found.findings} == {(FindingKind.FOLLOWING, Severity.TIGHT)}


# what follows from the whole day -----------------------------------------------------------------------------------


def test_a_day_without_fault_is_on_time_when_played_through() -> None:
    setup = good().setup()
    rehearsal = Rehearsal(setup, planned_day(setup))
    assert rehearsal.waits == []
    # trains aim to be there a little early
    assert max(one.late_s for one in rehearsal.late if not one.leaves) < 0.0
    assert max(one.late_s for one in rehearsal.late if one.leaves) == 0.0


def test_a_track_given_back_by_itself_lets_the_next_train_in_sooner() -> None:
    """T3 waits for the track at A until T1 is at B, or until that has left it: `rtri/76_by_section` runs it."""
    comes_s: dict[ReleaseRule, float] = {}
    for rule in ReleaseRule:
        setup = load_scenario(find_drill("rtri/76_by_section")).setup
        setup = replace(setup, operation=setup.operation.model_copy(update={"release": rule}))
        late = Rehearsal(setup, planned_day(setup)).late
        comes_s[rule] = next(one.late_s for one in late if (one.train.number, one.station_id) == ("T3", "A"))
    assert comes_s[ReleaseRule.SECTION] < comes_s[ReleaseRule.ROUTE] - 30.0


def test_a_shorter_lead_mends_what_a_long_one_breaks() -> None:
    plan = BREAKS["sent_into_each_other"]().plan
    assert feasibility(replace(plan, operation=Operation(portal_lead_s=120.0)).setup()).good


def test_small_delays_that_add_up_are_told_and_refused_in_the_end() -> None:
    """A stop before points costs 40 s: with 116 s to spare a hop that is made up, with none it adds up."""
    plan = good()
    line = plan.line
    tags = {i: tag for i, tag in line.tags.items() if tag.purpose is not TagPurpose.APPROACH}
    extra = {
        900 + i: replace(tag, id=900 + i, purpose=TagPurpose.POSITION)
        for i, tag in line.tags.items()
        if tag.purpose is TagPurpose.APPROACH
    }
    without = replace(plan, line=replace(line, tags=tags | extra))
    found = feasibility(without.setup())
    assert {f.kind for f in found.findings} == {FindingKind.TAG}
    assert found.good
    late = without
    for train in plan.trains:
        calls = tuple(
            call
            if k == 0
            else replace(
                call,
                arrival_s=call.arrival_s and call.arrival_s - 95 * k,
                departure_s=call.departure_s and call.departure_s - 95 * k,
            )
            for k, call in enumerate(train.calls)
        )
        late = late.with_train(replace(train, calls=calls))
    alone = replace(late, dwell_min_s=60, trains=(replace(late.train("D"), ends="stabled"),))
    (impossible,) = feasibility(alone.setup()).not_as_printed
    assert (impossible.kind, impossible.trains[0]) == (FindingKind.LATE, "D")
    assert (impossible.short_s or 0.0) >= 180.0


# words ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("track", "told"), [("EDO", FindingKind.TRACK), ("KAS", FindingKind.TERMINAL)])
def test_a_track_is_a_terminal_one_at_an_end_of_the_line_alone(track: str, told: FindingKind) -> None:
    """Q's set stays in the loop at Edogawa, or at the end of the line; 154 min before R is to come there."""
    here = STATIONS[: STATIONS.index(track) + 1]
    stays = journey("S1", "Q", "down", TEN, "portal:ASA.P", "stabled", "1" * len(here), here)
    comes = journey("S2", "R", "down", TEN + 9220, "portal:ASA.P", "stabled", "1" * len(here), here)
    plan = replace(good(), trains=(stays, comes))
    (finding,) = feasibility(plan.setup()).not_as_printed
    assert (finding.kind, finding.trains, finding.place) == (told, ("Q", "R"), track)


@pytest.mark.parametrize(
    ("time_s", "said"),
    [(0.4, "1 s"), (120.0, "120 s"), (120.5, "3 min"), (180.0, "3 min"), (9220.0, "154 min")],
)
def test_long_times_are_said_in_minutes(time_s: float, said: str) -> None:
    assert length_of_time(time_s) == said


def test_a_wait_of_hours_is_told_in_minutes() -> None:
    """D's set waits at Kasumi until 14:07 on the track that W is to have from 11:04; X stays on the other one."""
    goes = journey("S1", "U", "up", TEN + 4 * 3600, "from:D", "portal:ASA.P", "122222")
    comes = with_call(good().train("W"), "KAS", track="1")
    other = journey("S4", "X", "down", TEN + 16 * 60, "portal:ASA.P", "stabled", "111112")
    plan = replace(good(), trains=(good().train("D"), goes, comes, other))
    finding = next(f for f in feasibility(plan.setup()).not_as_printed if "W" in f.trains)
    assert finding.remedy == "W leaves for it 183 min later, at 14:07"


def test_a_leg_says_what_trains_need_as_driven_and_at_the_limits() -> None:
    """The busy line's hop of 6.6 km; `running-times` gives the time at the limits."""
    plan = good()
    short = plan.with_train(later(plan.train("W"), -150, "OKA"))
    setup = short.setup()
    (finding,) = (f for f in feasibility(setup).not_as_printed if f.kind is FindingKind.LEG)
    (leg,) = (g for g in planned_legs(setup) if (g.number, g.from_id, g.to_id) == ("W", "EDO", "OKA"))
    assert leg.least_s < leg.attainable_s - 1.0
    said = f"needs {leg.attainable_s:.0f} s as trains are driven, {leg.least_s:.0f} s at the limits"
    assert said in finding.text


# refusing ------------------------------------------------------------------------------------------------------------


def test_a_plan_is_refused_in_one_line_unless_it_is_to_run_anyway() -> None:
    setup = BREAKS["two_sets_stabled_on_one_track"]().plan.setup()
    with pytest.raises(PlanRefusedError) as refused:
        refuse("plan.toml", setup)
    text = str(refused.value)
    assert text.startswith("plan.toml cannot work: the sets of Y and Z are both to stand on ")
    assert text.endswith("; branchline check plan.toml shows all, --anyway runs it all the same")
    assert "\n" not in text
    assert not refuse("plan.toml", setup, anyway=True).good
    assert refuse("plan.toml", good().setup()).on_time


def test_a_plan_that_runs_late_is_not_refused() -> None:
    found = refuse("plan.toml", BREAKS["sent_too_late"]().plan.setup())
    assert found.good
    assert not found.on_time
    assert found.verdict.startswith(
        "late: it runs, but not as printed; D would come to Asahi at 10:00:26, 87 s late"
    )


def test_a_train_without_a_way_is_refused_even_then() -> None:
    with pytest.raises(PlanRefusedError, match=r"shows all$"):
        refuse("stub.toml", BREAKS["no_way"]().plan.setup(), anyway=True)


def test_a_train_of_one_stop_alone_is_refused() -> None:
    """A run has nothing of which it could say that it arrived."""
    train = replace(good().train("D"), ends="stabled", begins="stabled", calls=good().train("D").calls[3:4])
    (finding,) = feasibility(replace(good(), trains=(train,)).setup()).not_as_printed
    assert (finding.kind, finding.trains, finding.place) == (FindingKind.NO_WAY, ("D",), "EDO")


# sets between their trains -----------------------------------------------------------------------------------------


def test_a_set_that_is_stabled_between_two_trains_holds_its_track() -> None:
    plan = good()
    stays = replace(plan.train("D"), ends="stabled")
    goes = replace(plan.train("U"), begins="stabled")
    rests = plan.with_train(stays).with_train(goes)
    assert feasibility(rests.setup()).findings == ()
    clash = rests.with_train(with_call(rests.train("W"), "KAS", track="1"))
    first = feasibility(clash.setup()).not_as_printed[0]
    assert (first.kind, first.trains) == (FindingKind.TERMINAL, ("D", "W"))


def test_trains_of_one_set_are_never_in_its_own_way() -> None:
    plan = good()
    leaves_s = call_at(plan.train("U"), "KAS").departure_s
    assert leaves_s == TEN + 2 * 3600
    alone = replace(plan, trains=(plan.train("D"), plan.train("U")))
    assert feasibility(alone.setup()).findings == ()
    assert {train.direction for train in planned_day(alone.setup()).all()} == set(Direction)


# stops that are made, and wide --------------------------------------------------------------------------------------


@pytest.mark.parametrize("before_m", [400.0, 0.0])
def test_a_mark_without_tags_near_it_is_told_with_how_far_trains_stop_off_it(before_m: float) -> None:
    """A halt whose position tags are taken away: the stop is made, farther off than a summary calls at its mark."""
    setup = load_scenario("karasuyama_weekday").setup
    halt = next(station for station in setup.line.stations.values() if station.is_halt)
    marks_m = [m for track in halt.tracks for m in track.marks_m.values()]
    tags = {
        number: tag
        for number, tag in setup.line.tags.items()
        if tag.purpose is not TagPurpose.POSITION or min(abs(tag.position_m - m) for m in marks_m) > before_m
    }
    found = feasibility(replace(setup, line=replace(setup.line, tags=tags)))
    wide = [finding for finding in found.findings if finding.kind is FindingKind.STOP]
    assert [finding.place for finding in wide] == ([] if not before_m else [halt.id] * len(wide))
    assert bool(wide) is bool(before_m) and found.good
    for finding in wide:
        assert finding.severity is Severity.TIGHT
        assert f"m off its mark at {halt.name}" in finding.text and "position tag" in finding.remedy
        off_m = float(finding.text.partition("perhaps ")[2].partition(" m off")[0])
        assert OFF_MARK_M < off_m < CALLS_SHORT_M
