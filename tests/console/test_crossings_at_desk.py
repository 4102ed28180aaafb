"""Level crossings at the desk in whole runs of the paper's line: what each seat may do there and is shown, and that all
of it replays.
"""

from pathlib import Path
from typing import Any, Final

import pytest

from console.desk import Desk
from console.protocol import CrossingKnown, DeskAnswer, DoAct, EndFault, Fail, RoadState, State
from console.seats import Seat
from console.session import Session
from console.shown import SentSoFar, state_for
from scenario.scenario import Scenario, load_scenario
from simulation.setup import STEPS_PER_S
from study.drilling.drill import find_drill, run_drill
from study.runner.run import PartyLink

TEN: Final = 36_000
FAULTS: Final = {
    *("barriers_stuck", "lamps_dead", "crossing_undetected", "stalled_vehicle", "button_pressed"),
    *("detector_blind", "detector_occupied", "detector_off", "power_off"),
}


@pytest.fixture(scope="module")
def crossed() -> Scenario:
    """One train, and a crossing 307 m before its front as it leaves at ten."""
    return load_scenario(find_drill("rtri/100_crossing"))


@pytest.fixture(scope="module")
def with_road(tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    """The same with a road on which vehicles drive."""
    file = tmp_path_factory.mktemp("road") / "road.toml"
    road = "road = { vehicles_per_h = [120.0] }"
    crossing = f'[[patch.line.add.crossings]]\nid = "C1"\nsection = "6"\nkm = 0.75\n{road}\n'
    file.write_text(f'extends = "rtri_test_line"\nid = "road"\nname = "road"\n\n{crossing}', "utf-8")
    return load_scenario(str(file))


def act(desk: Desk, seat: Seat, kind: str, **keys: Any) -> DeskAnswer:  # noqa: ANN401
    return desk.ask(seat, DoAct(act={"kind": kind, "target": "C1", **keys}), 0.0, "K1")


def fail(desk: Desk, kind: str) -> int:
    answer = desk.ask(Seat.INSTRUCTOR, Fail(fault={"kind": kind, "target": "C1"}), 0.0)
    assert answer.good and answer.deed is not None, answer.why
    return answer.deed


def state_of(desk: Desk, seat: Seat) -> State:
    return state_for(desk.moment, seat, SentSoFar(), "K1")[0]


def shown(desk: Desk, seat: Seat) -> CrossingKnown:
    (one,) = state_of(desk, seat).crossings
    return one


def go_to(session: Session, after_ten_s: float) -> None:
    session.run_to(round((TEN + after_ten_s) * STEPS_PER_S))


def test_each_seat_sees_a_crossing_as_far_as_it_can_know_it(crossed: Scenario) -> None:
    """The warning begins 35 s before the front is there: 17 s after ten by the truth. Who hears the radio has a word of
    1.5 s after ten, for 15 s, and then none until the train asks again.
    """
    with Session(crossed) as session:
        desk = Desk(session)
        desk.cabs = frozenset({"K1"})
        seats = (Seat.INSTRUCTOR, Seat.DISPATCHER, Seat.STAFF, Seat.DRIVER)
        states: dict[float, list[RoadState]] = {}
        for after_s in (-60.0, 18.0, 35.0, 62.0):
            go_to(session, after_s)
            states[after_s] = [shown(desk, seat).state for seat in seats]
            cab = desk.moment.cabs["K1"]
            if after_s == 18.0:
                assert shown(desk, Seat.DISPATCHER).announced == ("K1",)
                assert "level crossing C1" in cab.why and "踏切C1" in cab.why_ja
                assert cab.crossing is not None and cab.crossing.ahead_m is not None
                assert cab.authority_m == pytest.approx(cab.crossing.ahead_m - 2.0, abs=0.5)
        assert cab.crossing is None  # it is behind
        result = session.run_to_end()
    silent = RoadState.UNHEARD
    assert states == {
        -60.0: [RoadState.OPEN, silent, silent, silent],
        18.0: [RoadState.WARNING, silent, silent, RoadState.ASKED],
        35.0: [RoadState.CLOSED] * 4,
        62.0: [RoadState.OPENING, RoadState.OPEN, RoadState.OPEN, silent],
    }
    assert result.digest == run_drill("rtri/100_crossing", PartyLink.SIMULATED).run.result.digest


@pytest.mark.parametrize(
    ("contact_km", "heard"), [(0.2, "C1"), (0.46, None)], ids=["begins beyond", "passes"]
)
def test_a_cab_shows_no_crossing_whose_contact_its_train_passes(
    contact_km: float, heard: str | None, tmp_path: Path
) -> None:
    """It stands at km 0.44. By a departure its unit asks; coming over the contact it asks nothing and hears nothing."""
    crossing = '[[patch.line.add.crossings]]\nid = "C1"\nsection = "6"\nkm = 0.75\ncontrol = "contacts"\n'
    contacts = f"departures = true\nstart_down_km = {contact_km}\nstart_up_km = 1.3\n"
    (tmp_path / "contact.toml").write_text(
        f'extends = "rtri_test_line"\nid = "contact"\nname = "contact"\n\n{crossing}{contacts}', "utf-8"
    )
    with Session(load_scenario(str(tmp_path / "contact.toml"))) as session:
        desk = Desk(session)
        desk.cabs = frozenset({"K1"})
        go_to(session, -5.0)
        ahead = desk.moment.cabs["K1"].crossing
    assert (None if ahead is None else ahead.name) == heard


def test_a_crossing_can_be_broken_in_every_way(crossed: Scenario) -> None:
    with Session(crossed) as session:
        welcome = Desk(session).welcome(Seat.INSTRUCTOR)
        assert {one.kind for one in welcome.faults if "C1" in one.targets} >= FAULTS
        (drawn,) = welcome.crossings
        assert (drawn.section, drawn.at_m, drawn.has_device, drawn.by_radio) == ("6", 750.0, True, True)
        for kind in sorted(FAULTS):
            fail(Desk(session), kind)


@pytest.mark.parametrize(
    ("kind", "may"),
    [
        ("free_road", {Seat.INSTRUCTOR, Seat.DISPATCHER, Seat.STAFF}),
        ("guard_road", {Seat.INSTRUCTOR, Seat.STAFF}),
        ("leave_road", {Seat.INSTRUCTOR, Seat.STAFF}),
    ],
)
def test_who_may_say_what_at_a_crossing(crossed: Scenario, kind: str, may: set[Seat]) -> None:
    with Session(crossed) as session:
        desk = Desk(session)
        assert {seat for seat in Seat if act(desk, seat, kind).good} == may
        assert {seat for seat in Seat if kind in desk.welcome(seat).acts} == may


def test_a_stuck_barrier_is_guarded_from_the_staff_seat_and_it_replays(
    with_road: Scenario, tmp_path: Path
) -> None:
    with Session(with_road) as session:
        desk = Desk(session)
        desk.cabs = frozenset({"K1"})
        go_to(session, -100.0)
        number = fail(desk, "barriers_stuck")
        assert act(desk, Seat.STAFF, "guard_road").good
        go_to(session, 75.0)
        seats = (Seat.INSTRUCTOR, Seat.DISPATCHER, Seat.DRIVER)
        assert [shown(desk, seat).guarded for seat in seats] == [True] * 3
        states = [shown(desk, seat).state for seat in seats]
        assert states == [RoadState.UNPROVEN, RoadState.UNPROVEN, RoadState.ASKED]
        told = "not detected in time"
        assert [shown(desk, seat).why for seat in (Seat.INSTRUCTOR, Seat.DISPATCHER)] == [told, ""]
        while not shown(desk, Seat.DRIVER).creeps:
            go_to(session, session.now_s - TEN + 1.0)
        cab = desk.moment.cabs["K1"]
        assert cab.on_sight and cab.crossing is not None and cab.crossing.creeps
        texts = [event.text for event in state_of(desk, Seat.DRIVER).events]
        assert "the driver has leave to creep over level crossing C1, its road stopped by hand" in texts
        assert desk.ask(Seat.INSTRUCTOR, EndFault(deed=number), 0.0).good
        assert act(desk, Seat.STAFF, "leave_road").good
        result = session.run_to_end()
        assert all(count == 0 for count in session.simulation.checkers.counts.values())
        text = session.drill_text("saved", "saved")
    file = tmp_path / "saved.toml"
    file.write_text(text, "utf-8")
    again = run_drill(str(file), PartyLink.SIMULATED).run.result
    assert (again.digest, again.motion_digest) == (result.digest, result.motion_digest)


def test_two_persons_free_a_road_at_two_seats_and_each_is_answered(crossed: Scenario) -> None:
    with Session(crossed) as session:
        desk = Desk(session)
        go_to(session, 20.0)
        assert act(desk, Seat.DISPATCHER, "free_road").good
        assert act(desk, Seat.STAFF, "free_road").good
        go_to(session, 21.0)
        said = [event for event in state_of(desk, Seat.DISPATCHER).events if event.who == "C1"]
    assert [event.text for event in said] == [
        "controller says that no train comes",
        "staff says that no train comes, as another person has said: proofs are taken back",
    ]
    assert all("列車の来ないことを通告" in event.text_ja for event in said)


def test_what_stands_on_it_is_seen_by_the_instructor(with_road: Scenario) -> None:
    with Session(with_road) as session:
        desk = Desk(session)
        desk.cabs = frozenset({"K1"})
        go_to(session, 36.0)
        fail(desk, "stalled_vehicle")
        go_to(session, 40.0)
        seen = {seat: shown(desk, seat).occupied for seat in (Seat.INSTRUCTOR, Seat.DISPATCHER, Seat.DRIVER)}
    assert seen == {Seat.INSTRUCTOR: True, Seat.DISPATCHER: False, Seat.DRIVER: False}
