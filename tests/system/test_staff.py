"""Staff who react put right what nothing puts right by itself, after a time of their own; else it stays as it is."""

from collections.abc import Callable
from pathlib import Path
from typing import Final

import pytest

from simulation.events import CrossingEntered, RoadGuarded
from simulation.faults.script import Act, ActKind
from simulation.people import People
from simulation.staff import Staff
from simulation.world.crossings import CrossingsOnTrack
from study.drilling.drill import find_drill
from study.runner.run import FinishedRun
from tests.nightly import others_nightly
from tests.plain import drill_of, drill_on_plain
from wayside.crossing_said import CrossingOpens
from wayside.said import ConfirmedByHand

HEAD: Final = """
extends = "rtri_test_line"
id = "staff"
name = "What staff put right"
timetable = "rtri_two_trains"
"""
ENDS_SOON: Final = "limits.time_limit_s = 1200.0\n"  # what nobody has put right by then stays so
# What fails, and never heals by itself; what somebody does about it.
FAILS: Final[dict[str, tuple[str, frozenset[ActKind]]]] = {
    "unit": (
        '[[fault]]\nkind = "power_off"\ntarget = "K1"\nstart = "10:00:30"\n',
        frozenset({ActKind.POWER_ON}),
    ),
    "manager": (
        '[[fault]]\nkind = "power_off"\ntarget = "block-manager"\nstart = "09:59:30"\n',
        frozenset({ActKind.POWER_ON, ActKind.REENTER_ASSISTED}),
    ),
    "manager by hand": (
        '[operation]\nreentry = "by_hand"\n'
        '[[fault]]\nkind = "restart"\ntarget = "block-manager"\nstart = "10:00:50"\n',
        frozenset({ActKind.ENTER_SECTION, ActKind.ACCEPT_PICTURE}),
    ),
    "manager's store": (
        '[[fault]]\nkind = "lost_store"\ntarget = "block-manager"\nstart = "10:00:30"\nduration_s = 30.0\n',
        frozenset({ActKind.COMMISSION, ActKind.REENTER_ASSISTED}),
    ),
    "points": (
        '[[fault]]\nkind = "stuck"\ntarget = "P7"\nstart = "09:59:00"\n',
        frozenset({ActKind.REPAIR_POINTS}),
    ),
    "a train in a portal": (
        "".join(
            f'[[fault]]\nkind = "power_off"\ntarget = "{party}"\nstart = "10:08:21"\nduration_s = {lasts_s}\n'
            for party, lasts_s in (("block-manager", 120.0), ("K1", 60.0), ("K2", 60.0))
        ),
        frozenset({ActKind.REENTER_ASSISTED, ActKind.CONFIRM_HOLDING}),
    ),
}

Fails = Callable[..., FinishedRun]


@pytest.fixture
def fails(tmp_path: Path) -> Fails:
    def run(what: str, people: str, limits: str = "") -> FinishedRun:
        return drill_of(tmp_path, f"{HEAD}people = {{ {people} }}\n{limits}{FAILS[what][0]}").run

    return run


def _acts(run: FinishedRun) -> list[Act]:
    return [course.item for course in run.result.courses if isinstance(course.item, Act)]


@pytest.mark.parametrize("what", others_nightly(FAILS, ["unit"]))
def test_what_nobody_sees_to_stays_as_it_is(what: str, fails: Fails) -> None:
    result = fails(what, "react = false", ENDS_SOON).result
    assert result.unfinished


@pytest.mark.parametrize("what", others_nightly(FAILS, ["manager", "points", "a train in a portal"]))
def test_staff_put_it_right(what: str, fails: Fails) -> None:
    run = fails(what, "react = true")
    assert not run.result.unfinished
    assert run.result.violations == ()
    acts = _acts(run)
    assert FAILS[what][1] <= {act.kind for act in acts}
    for unit_id in {act.target for act in acts if act.kind is ActKind.CONFIRM_HOLDING}:
        assert len({act.person for act in acts if act.target == unit_id}) == 2


def test_they_take_their_time(fails: Fails) -> None:
    def first_s(people: str) -> float:
        return min(c.begun_s for c in fails("unit", people).result.courses if isinstance(c.item, Act))

    quick_s = first_s("react = true, power_s = 10.0, sigma = 0.0, word_s = 0.0")
    slow_s = first_s("react = true, power_s = 300.0, sigma = 0.0, word_s = 0.0")
    assert quick_s - 36_030.0 == pytest.approx(10.0, abs=12.0)  # a stretch may be long while all stand
    assert slow_s - quick_s == pytest.approx(290.0, abs=12.0)


def test_the_same_run_has_the_same_staff(fails: Fails) -> None:
    digests = {fails("manager", "react = true").result.digest for _ in range(2)}
    assert len(digests) == 1
    assert digests != {fails("manager", "react = true, picture_s = 90.0").result.digest}


def test_nobody_reacts_unless_it_is_said() -> None:
    assert not People().react


@pytest.mark.nightly
def test_a_bar_that_one_device_did_not_hear_of_is_said_again(tmp_path: Path) -> None:
    """The block manager is off when the second person unbars: only who looks at its screen sees that. Their patience is
    such that nobody unbars it before of themselves.
    """
    arrives: dict[str, bool] = {}
    for react in ("true", "false"):
        run = drill_of(
            tmp_path,
            'extends = "'
            + find_drill("rtri/59_unit_barred")
            + f'"\nid = "bar"\npeople = {{ react = {react}, silent_s = 1800.0 }}\nexpect = []\n'
            '[[fault]]\nkind = "power_off"\ntarget = "block-manager"\nstart = "10:20:06.5"\nduration_s = 60.0\n'
            '[[patch.act.add]]\nkind = "reenter_assisted"\nstart = "10:21:30"\n',
        ).run
        arrives[react] = not run.result.unfinished
        said = [act.person for act in _acts(run) if act.kind is ActKind.UNBAR_UNIT]
        assert sorted(set(said)) == ["controller", "station staff"]
        assert (len(said) > 2) is (react == "true")
    assert arrives == {"true": True, "false": False}


def test_what_a_mad_unit_outside_has_been_given_is_had_back(tmp_path: Path) -> None:
    """It claimed a free section when its train had left; sane again it is never asked, and T3 needs that section."""
    arrives: dict[str, bool] = {}
    for react in ("true", "false"):
        run = drill_of(
            tmp_path,
            'extends = "rtri_test_line"\ntimetable = "rtri_following"\nid = "mad"\nname = "mad"\n'
            f"people.react = {react}\n{ENDS_SOON}"
            '[[fault]]\nkind = "false_claims"\ntarget = "K1"\nsection = "7"\nstart = "10:04:30"\nduration_s = 30.0\n',
        ).run
        arrives[react] = not run.result.unfinished
        assert run.result.collisions == ()
        kinds = {act.kind for act in _acts(run)}
        staff_did = {ActKind.BAR_UNIT, ActKind.CONFIRM_OUTSIDE, ActKind.UNBAR_UNIT}
        assert kinds >= staff_did if react == "true" else not kinds
    assert arrives == {"true": True, "false": False}


@pytest.mark.parametrize("asks", [True, False])
def test_points_are_wound_for_a_train_that_has_slid_just_onto_them(
    asks: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It stands 1.6 m in their section, 8.4 m short of the blades, without a proof: no unit throws them there."""
    if not asks:
        monkeypatch.setattr(Staff, "_asked_for", lambda *_: "")
    run = drill_of(
        tmp_path,
        f'extends = "{find_drill("rtri/27_slippery_rail")}"\nid = "slid"\nname = "slid"\nexpect = []\n'
        f"people.react = true\n{ENDS_SOON}"
        '[[patch.fault.add]]\nkind = "cut"\ntarget = "K1 -> B-W"\nstart = "10:00:41"\nduration_s = 60.0\n',
    ).run
    assert bool(run.result.trains_arrived) is asks
    by_hand = [act for act in _acts(run) if act.kind is ActKind.REPAIR_POINTS]
    assert [act.position for act in by_hand] == (["normal"] if asks else [])


def test_a_barred_train_that_may_come_in_is_not_said_to_be_outside(tmp_path: Path) -> None:
    """Its crew takes ten minutes; said to be outside, it would come into a portal that the register has free."""
    bars = "".join(
        '[[act]]\nkind = "bar_unit"\ntarget = "K2"\n'
        'start = { who = "block-manager", what = "accepted", unit = "K2" }\n'
        f'after_s = {after_s}\nperson = "{person}"\n'
        for after_s, person in ((5.0, "Sato"), (8.0, "Mori"))
    )
    run = drill_of(
        tmp_path,
        'extends = "rtri_test_line"\ntimetable = "rtri_following"\nid = "slow"\nname = "slow"\n'
        f"people = {{ react = true, entry_s = 600.0, sigma = 0.0 }}\n{bars}",
    ).run
    said = [act for act in _acts(run) if act.kind in (ActKind.CONFIRM_OUTSIDE, ActKind.CONFIRM_HOLDING)]
    assert {(act.kind, act.target, act.sections) for act in said} == {
        (ActKind.CONFIRM_HOLDING, "K2", ("PW",))
    }
    assert not run.result.violations


def _wrong_word(tmp_path: Path, kind: ActKind) -> FinishedRun:
    """Of K2, which waits outside and is not heard for a minute after the manager's restart, one says what is not so."""
    return drill_of(
        tmp_path,
        'extends = "rtri_test_line"\ntimetable = "rtri_two_trains"\nid = "wrong"\nname = "wrong"\n'
        f"people = {{ react = true, sigma = 0.0 }}\n{ENDS_SOON}"
        '[[fault]]\nkind = "restart"\ntarget = "block-manager"\nstart = "10:00:20"\n'
        '[[fault]]\nkind = "cut"\ntarget = "K2 -> block-manager"\nstart = "10:00:15"\nduration_s = 60.0\n'
        f'[[act]]\nkind = "{kind.value}"\ntarget = "K2"\nsections = ["10"]\nstart = "10:00:40"\n'
        'person = "trackman"\n',
    ).run


@pytest.mark.parametrize("kind", [ActKind.CONFIRM_HOLDING, ActKind.ENTER_SECTION])
@pytest.mark.parametrize("corrects", [True, False])
def test_a_wrong_word_is_taken_back_when_its_unit_speaks_for_itself(
    kind: ActKind, corrects: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """K2 says that it is outside; what the trackman has entered for it would keep the line from being defined."""
    if not corrects:
        monkeypatch.setattr(Staff, "_taken_back", lambda *_: None)
    run = _wrong_word(tmp_path, kind)
    said = [(act.kind, act.person) for act in _acts(run) if act.target == "K2"]
    wrong = (kind, "trackman")
    assert said == [wrong, (ActKind.TAKE_BACK, "trackman")] if corrects else [wrong]
    assert (run.result.unfinished == ()) is corrects


def test_nobody_speaks_for_a_unit_that_has_answered_what_one_person_said(tmp_path: Path) -> None:
    """K1 says what the register has, so nothing but the refusal of the trackman's word shows that it was heard."""
    run = drill_of(
        tmp_path,
        'extends = "rtri_test_line"\ntimetable = "rtri_two_trains"\nid = "answers"\nname = "answers"\n'
        "people = { react = true, sigma = 0.0, silent_s = 60.0 }\n"
        '[[act]]\nkind = "confirm_holding"\ntarget = "K1"\nsections = ["8"]\nstart = "10:02:00"\n'
        'person = "trackman"\n',
    ).run
    assert [act.person for act in _acts(run)] == ["trackman"]
    assert not run.result.unfinished


PEOPLE_WITH_A_SLOW_CREW: Final = "sigma = 0.0, picture_s = 15.0, silent_s = 60.0, boot_s = 300.0"


def _spoken_for(tmp_path: Path, timetable: str, *off: tuple[str, str, float]) -> set[tuple[str, ...]]:
    """What persons say that K1 holds, whose crew takes five minutes to enter its number after a boot."""
    faults = "".join(
        f'[[fault]]\nkind = "power_off"\ntarget = "{party}"\nstart = "{at}"\nduration_s = {lasts_s}\n'
        for party, at, lasts_s in off
    )
    run = drill_of(
        tmp_path,
        f'extends = "rtri_test_line"\ntimetable = "{timetable}"\nid = "spoken"\nname = "spoken"\n'
        f"people = {{ react = true, {PEOPLE_WITH_A_SLOW_CREW} }}\n{faults}",
    ).run
    assert not run.result.unfinished
    assert not run.result.violations
    acts = [act for act in _acts(run) if act.kind in (ActKind.CONFIRM_HOLDING, ActKind.ENTER_SECTION)]
    return {act.sections for act in acts if act.target == "K1"}


def test_a_unit_that_has_booted_and_has_no_number_yet_is_said_to_hold_what_it_was_granted(
    tmp_path: Path,
) -> None:
    """K1 stands in section 6 with its way into B, which manager and unit have both forgotten."""
    off = ("block-manager", "10:00:35", 1.0), ("K1", "10:00:35", 20.0)
    assert _spoken_for(tmp_path, "rtri_two_trains", *off) == {("6", "7", "8"), ("7", "8")}


def test_what_a_train_has_run_through_is_not_said_to_be_held_when_it_lies_ahead_again(tmp_path: Path) -> None:
    """K1 came into B while the manager was off, which never heard that it gave its way back, and has turned."""
    came_in = ("block-manager", "10:00:40", 80.0)
    off = came_in, ("block-manager", "10:03:40", 1.0), ("K1", "10:03:40", 20.0)
    assert _spoken_for(tmp_path, "rtri_turn_back", *off) == {("8",)}


def test_who_is_barred_at_terminals_alone_is_unbarred_whatever_the_manager_has_asked(tmp_path: Path) -> None:
    """The manager was off when K1 was barred. What the trackman enters just before the picture is accepted has it ask
    K1, whose answer changes nothing; it stands on open line, where nobody's word counts against its own.
    """
    said = (
        ("bar_unit", "10:00:25", "Sato"),
        ("bar_unit", "10:00:26", "Mori"),
        ("unbar_unit", "10:00:45", "Sato"),  # he and Mori do not agree any more
    )
    run = drill_of(
        tmp_path,
        'extends = "rtri_test_line"\ntimetable = "rtri_two_trains"\nid = "alone"\nname = "alone"\n'
        "people = { react = true, sigma = 0.0 }\n"
        '[[fault]]\nkind = "power_off"\ntarget = "block-manager"\nstart = "10:00:20"\nduration_s = 30.0\n'
        '[[act]]\nkind = "enter_section"\ntarget = "K1"\nsections = ["10"]\nstart = "10:02:02"\nperson = "trackman"\n'
        + "".join(
            f'[[act]]\nkind = "{kind}"\ntarget = "K1"\nstart = "{at}"\nperson = "{person}"\n'
            for kind, at, person in said
        ),
    ).run
    by_hand = [
        entry.event for entry in run.result.journal.entries if isinstance(entry.event, ConfirmedByHand)
    ]
    assert [event.unit_id for event in by_hand if "10" in event.section_ids] == ["K1"]
    assert not run.result.unfinished


def test_points_that_work_again_are_left_alone(tmp_path: Path) -> None:
    """Who comes to wind them looks again: by then a train may be on them."""
    file = tmp_path / "staff.toml"
    people = "people = { react = true, points_s = 10.0, word_s = 50.0, sigma = 0.0 }\n"
    stuck = '[[fault]]\nkind = "stuck"\ntarget = "P5"\nstart = "10:00:00"\nduration_s = 20.0\n'
    file.write_text(HEAD + people + stuck, "utf-8")
    assert not _acts(drill_on_plain(str(file)).run)


def test_a_road_is_freed_while_people_work_the_line(tmp_path: Path) -> None:
    """The manager is off for hours, and K1's unit is cut out before the crossing has heard that it is over it."""
    run = drill_of(
        tmp_path,
        'extends = "rtri_test_line"\ntimetable = "rtri_two_trains"\nid = "road"\nname = "road"\n'
        "people = { react = true, notice_s = 20.0, reach_s = 60.0 }\n"
        'substitute = { staffed = ["A"], speed_kmh = 35.0 }\n'
        '[[patch.line.add.crossings]]\nid = "C1"\nsection = "6"\nkm = 0.75\n'
        '[[fault]]\nkind = "power_off"\ntarget = "block-manager"\nstart = "10:00:10"\n'
        '[[fault]]\nkind = "cut"\ntarget = "K1 -> C1"\nstart = "10:00:45"\nduration_s = 900.0\n',
    ).run
    assert {act.kind for act in _acts(run)} == {ActKind.FREE_ROAD}
    struck_off = [
        e.event.struck_off for e in run.result.journal.entries if isinstance(e.event, CrossingOpens)
    ]
    assert struck_off == [("K1",)]
    assert not run.result.unfinished


@pytest.mark.parametrize("frozen", [True, False])
def test_a_driver_who_comes_onto_an_open_road_reports_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, frozen: bool
) -> None:
    """Contacts tell no train anything: that their device does nothing, and has no watchdog that drops its relays, who
    drives over the road is the first to see.
    """
    monkeypatch.setattr(CrossingsOnTrack, "relays_fall", lambda *_: None)
    crossing = '[[patch.line.add.crossings]]\nid = "C1"\nsection = "6"\nkm = 0.85\ncontrol = "contacts"\n'
    fault = f'[[fault]]\nkind = "frozen"\ntarget = "C1"\nstart = "{"09" if frozen else "10"}:59:00"\n'
    people = "people = { react = true, guard_s = 5.0, sigma = 0.0 }\n"
    run = drill_of(tmp_path, f"{HEAD}{people}{crossing}start_down_km = 0.5\nstart_up_km = 1.2\n{fault}").run
    events = [(entry.t_s, entry.event) for entry in run.result.journal.entries]
    came_s = min(t_s for t_s, event in events if isinstance(event, CrossingEntered))
    guarded_s = [t_s for t_s, event in events if isinstance(event, RoadGuarded) and event.there]
    assert bool(guarded_s) is frozen
    assert all(came_s + 5.0 <= at_s <= came_s + 20.0 for at_s in guarded_s)
    assert bool(run.result.violations) is frozen  # the judge sees it too
