"""What the desk lists of what is said again and again."""

from console.forecast import DayForecast
from console.line_seen import LineSeen
from onboard.notes import Arrived, Departs, MissionBegun, SignOnDenied
from scenario.scenario import load_scenario
from simulation.events import MANAGER, Acted, Event, JournalEntry
from wayside.said import Accepted, Granted, Refused

HELD = Refused(unit_id="K1", section_ids=("8",), other_id="K2", why="HELD")
UNDEFINED = Refused(unit_id="K1", why="UNDEFINED")
GRANTED = Granted(unit_id="K1", section_ids=("8",), token=1, route_id="3>8")


def listed(*events: tuple[str, Event]) -> list[float]:
    """Which of the events, a second apart, are in the list."""
    line = LineSeen(load_scenario("rtri_test_line").setup)
    for t_s, (who, event) in enumerate(events):
        line.see(JournalEntry(float(t_s), who, event))
    return [event.shown.time_s for event in line.events]


def test_an_answer_that_a_unit_has_had_is_listed_once_until_it_has_another() -> None:
    asked: list[tuple[str, Event]] = [
        (MANAGER, HELD),
        (MANAGER, UNDEFINED),
        (MANAGER, HELD),
        ("K1", SignOnDenied(why="undefined")),
    ]
    assert listed(*asked, *asked) == [0.0, 1.0, 3.0]
    granted = (MANAGER, GRANTED)
    assert listed(*asked[:3], granted, *asked) == [0.0, 1.0, 4.0, 5.0, 7.0]  # a grant is seen in the sections


def test_what_one_unit_has_had_is_another_answer_to_another_and_by_another() -> None:
    other = Refused(unit_id="K2", section_ids=("8",), other_id="K2", why="HELD")
    assert listed((MANAGER, HELD), (MANAGER, other), ("A-E", HELD), (MANAGER, HELD)) == [0.0, 1.0, 2.0]


def test_each_word_of_a_person_is_answered() -> None:
    word = (MANAGER, Refused(unit_id="K1", why="Sato: the unit is reported"))
    assert listed(word, word) == [0.0, 1.0]


def test_who_did_something_is_said_in_the_language_of_the_reader() -> None:
    """A unit goes by its id, an act by what it is called; in English by the word of files."""
    line = LineSeen(load_scenario("rtri_test_line").setup)
    for who, event in (
        (MANAGER, HELD),
        ("controller", Acted(act="hold_train", target="K1")),
        ("K1", SignOnDenied(why="held")),
    ):
        line.see(JournalEntry(0.0, who, event))
    told = [event.shown for event in line.events]
    assert [one.who_ja for one in told] == ["閉そく管理装置", "指令員", "K1"]
    assert (told[1].who, told[1].text_ja) == ("controller", "列車の抑止（K1）")


def test_how_late_a_train_was_is_not_said_of_the_next_of_its_set() -> None:
    """T1 is to come to B at 10:02:00 and comes at 10:07:00; its set goes on as T3, which has not left yet."""
    line = LineSeen(load_scenario("rtri_test_line").setup)

    def late_s(event: Event) -> list[float | None]:
        line.see(JournalEntry(10 * 3600.0 + 420.0, "K1", event))
        return [train.late_s for train in line.trains(10 * 3600.0 + 420.0)]

    assert late_s(MissionBegun(train="T1", direction="down")) == [420.0]  # it is to leave at 10:00:00
    assert late_s(Arrived(station="B", error_m=0.0)) == [300.0]
    assert late_s(MissionBegun(train="T1", direction="down")) == [300.0]  # its unit has begun again
    assert late_s(MissionBegun(train="T3", direction="down")) == [None]


def test_a_train_is_as_late_as_what_it_is_to_do_next_is_overdue() -> None:
    """T1 is to leave A at 10:00:00 and to come to B at 10:02:00; what it did last was to time."""
    line = LineSeen(load_scenario("rtri_test_line").setup)

    def late_s(t_s: float, event: Event, *seen_at_s: float) -> list[float | None]:
        line.see(JournalEntry(36000.0 + t_s, "K1", event))
        return [train.late_s for at_s in seen_at_s for train in line.trains(36000.0 + at_s)]

    assert late_s(-60.0, MissionBegun(train="T1", direction="down"), -1.0, 600.0) == [None, 600.0]
    assert late_s(0.0, Departs(station="A"), 60.0, 121.0, 420.0) == [0.0, 1.0, 300.0]
    assert late_s(120.0, Arrived(station="B", error_m=0.0), 9000.0) == [0.0]  # it has nothing more to do


def test_a_set_turned_short_is_late_from_its_departure_there() -> None:
    """328M is to leave Karasuyama at 08:26 and Ogane, where the set is, at 08:47."""
    line = LineSeen(load_scenario("karasuyama_weekday").setup)
    for event in (MissionBegun(train="325M", direction="down"), Arrived(station="OGN", error_m=0.0)):
        line.see(JournalEntry(28080.0, "V4", event))
    line.see(JournalEntry(28200.0, "V4", MissionBegun(train="328M", direction="up")))
    seen = [train.late_s for at_s in (31000.0, 31680.0) for train in line.trains(at_s) if train.unit == "V4"]
    assert seen == [None, 60.0]


def test_the_forecast_knows_where_a_train_began_that_signed_on_where_it_stands() -> None:
    """T1 stands at A from the morning, has its route at 09:59:55 and leaves to time: it is due at B as printed."""
    setup = load_scenario("rtri_test_line").setup
    calls = setup.timetable.trains["T1"].calls
    leaves_s, due_s = float(calls[0].departure_s or 0), float(calls[-1].arrival_s or 0)
    forecast = DayForecast(setup)
    line = LineSeen(setup, forecast)
    stands = Accepted(unit_id="K1", section_ids=("3",), token=1, was="unknown")
    route = Granted(unit_id="K1", section_ids=("5", "6", "7", "8"), token=2, route_id="3>8")
    for t_s, who, event in (
        (leaves_s - 600.0, MANAGER, stands),
        (leaves_s - 5.0, MANAGER, route),
        (leaves_s, "K1", Departs(station="A")),
    ):
        line.see(JournalEntry(t_s, who, event))
    (train,) = (one for one in line.forecast(leaves_s + 60.0) if one.train == "T1")
    assert train.times_s[0] == due_s
