"""A timetable that is written as an OuDiaSecond file is read back the same; what somebody has taken away is said."""

import re
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exchange.onto_line import onto_line
from exchange.oudia.exact import read_back
from exchange.oudia.nodes import parse_oudia
from exchange.oudia.published import published_of
from exchange.oudia.route import route_of
from exchange.oudia.writer import AS_RUN, oudia_of, plan_name
from exchange.timetable_writer import file_of_timetable, timetable_toml
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_names, shipped_timetable
from network.files.timetable_schema import TimetableFile
from network.files.toml_input import parse_toml, read_text
from network.model import Line
from network.timetable import Timetable, load_timetable, parse_timetable, timetable_of
from tests.exchange.random_timetables import timetables

LINES = {name: load_line(shipped_line(name)) for name in shipped_names("lines")}
KARASUYAMA = LINES["karasuyama"]


def _again(timetable: Timetable, line: Line, as_run: bool = False) -> Timetable:
    trains = tuple(timetable.trains.values()) if as_run else ()
    text = oudia_of(line, timetable, trains)
    data = text.encoded()
    parsed = parse_oudia(data, "day.oud2")
    assert parsed.encoded() == data
    route = route_of(parsed, "day.oud2")
    back = read_back(route, route.dia(plan_name(timetable)), line)
    assert back.file is not None, back.why
    return timetable_of(back.file, "day.oud2", line)


@pytest.mark.parametrize("name", shipped_names("timetables"))
def test_a_shipped_timetable_is_read_back_the_same(name: str) -> None:
    path = shipped_timetable(name)
    line = LINES[parse_toml(read_text(path), name, TimetableFile).timetable.line]
    timetable = load_timetable(path, line)
    assert _again(timetable, line) == timetable
    assert _again(timetable, line, as_run=True) == timetable


@pytest.mark.parametrize("name", ["karasuyama", "busy_line"])
@given(data=st.data())
def test_any_timetable_is_read_back_the_same(name: str, data: st.DataObject) -> None:
    line = LINES[name]
    timetable = data.draw(timetables(line))
    assert _again(timetable, line) == timetable
    written = timetable_toml(file_of_timetable(timetable))
    assert parse_timetable(written, "written", line) == timetable


@given(data=st.data())
def test_any_timetable_keeps_its_times_without_what_we_wrote_beside_it(data: st.DataObject) -> None:
    timetable = data.draw(timetables(KARASUYAMA, fastest_mps=50.0))
    text = oudia_of(KARASUYAMA, timetable).encoded().decode("utf-8-sig")
    apart_s = [int(found) for found in re.findall(r"^NextEkiDistance=(.*)$", text, re.MULTILINE)]
    at_m = sorted(station.position_m for station in KARASUYAMA.stations.values())
    assert apart_s == pytest.approx(
        [(b - a) * 3.6 / 50.0 for a, b in pairwise(at_m)], abs=0.501
    )  # at 50 km/h
    text = re.sub(r"^Comment=.*$", "Comment=", text, flags=re.MULTILINE)
    route = route_of(parse_oudia(b"\xef\xbb\xbf" + text.encode(), "day.oud2"), "day.oud2")
    dia = route.dia(None)
    assert read_back(route, dia, KARASUYAMA).file is None
    onto = onto_line(published_of(route, dia), KARASUYAMA)
    assert {train.number for train in onto.trains} == set(timetable.trains)
    for train in onto.trains:
        planned = timetable.trains[train.number]
        assert (train.direction, train.revenue) == (planned.direction, planned.revenue)
        ours = {call.station_id: call for call in train.calls}
        for call in planned.calls:
            shift_s = ours[planned.calls[0].station_id].last_s - planned.calls[0].last_s
            assert shift_s % 86_400 == 0
            found = ours[call.station_id]
            assert found.last_s - shift_s == call.last_s
            if call.arrival_s is not None and call.station_id != planned.calls[0].station_id:
                assert found.arrival_s is not None
                assert found.arrival_s - shift_s == call.arrival_s


def _edited(*changes: tuple[str, str]) -> str:
    """Why the file of the Karasuyama weekday is not read back after these changes of its text."""
    timetable = load_timetable(shipped_timetable("karasuyama_weekday"), KARASUYAMA)
    text = oudia_of(KARASUYAMA, timetable).encoded().decode("utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    route = route_of(parse_oudia(text.encode("utf-8"), "day.oud2"), "day.oud2")
    back = read_back(route, route.dias[0], KARASUYAMA)
    return "" if back.file is not None else back.why or "nothing is carried"


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (
            ("Operation0B=4/0$537/$/V2\r\n", ""),
            "train 321M does not run, or its set has other operations now",
        ),
        (("/V2\r\n", "/\r\n"), "train 321M has no set"),
        (("Ressyabangou=323M", "Ressyabangou=321M"), "a train has the number '321M'"),
        (("Ekimei=大金", "Ekimei=小金"), "its stations are others now"),
        (("DiaName=Karasuyama Line, weekdays", "DiaName=平日"), "'平日' is not the plan"),
        (('line = "karasuyama"', 'line = "elsewhere"'), "for the line elsewhere"),
        (("1;537$0,1;542/543", "1;547$0,1;542/543"), "changed since"),
        (("# branchline", "# somebody"), "nothing is carried"),
        (("dwell_min_s = 20", "dwell_min_s = twenty"), "changed since"),
    ],
)
def test_what_is_gone_from_a_file_is_said(change: tuple[str, str], why: str) -> None:
    assert why in _edited(change)


def test_a_change_that_fits_is_taken() -> None:
    assert _edited(("1;542/543", "1;542/54330")) == ""


def test_the_plan_is_not_called_as_the_day_as_run_is() -> None:
    timetable = load_timetable(shipped_timetable("rtri_test_line"), LINES["rtri_test_line"])
    assert plan_name(timetable) != AS_RUN
