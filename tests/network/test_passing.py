"""What a timetable says of passing, of standing without passengers, and of tracks without a platform."""

from collections.abc import Sequence

import pytest

from network.errors import InputError
from network.files.line_file import parse_line
from network.timetable import CallKind, parse_timetable
from tests.network.sample import LINE, SAMPLE

FIRST = '{ station = "A", track = "1", departure = "06:01" }'
LAST = '{ station = "B", track = "1", arrival = "06:06" }'


def day(*calls: str, revenue: bool = True) -> str:
    return f"""
[timetable]
id = "day"
line = "sample"
[[trains]]
number = "1"
direction = "down"
revenue = {str(revenue).lower()}
begins = "portal:P"
ends = "stabled"
calls = [{", ".join(calls)}]
[[diagrams]]
stock = "K1"
trains = ["1"]
"""


def test_a_passing_has_one_time_and_no_stop() -> None:
    timetable = parse_timetable(day(FIRST, '{ station = "H", pass = "06:03:30" }', LAST), "day.toml", LINE)
    call = timetable.trains["1"].calls[1]
    assert (call.kind, call.stops, call.arrival_s, call.departure_s) == (CallKind.PASS, False, None, 21_810)


def test_a_stop_may_be_for_nobody() -> None:
    calls = (FIRST, '{ station = "H", arrival = "06:03", departure = "06:04", operational = true }', LAST)
    call = parse_timetable(day(*calls), "day.toml", LINE).trains["1"].calls[1]
    assert (call.kind, call.stops) == (CallKind.OPERATIONAL, True)


@pytest.mark.parametrize(
    ("calls", "key"),
    [
        ((FIRST, '{ station = "H", pass = "06:03", departure = "06:04" }', LAST), "calls[1].departure"),
        ((FIRST, '{ station = "H", pass = "06:03", operational = true }', LAST), "calls[1].operational"),
        ((FIRST, '{ station = "H", pass = "06:00" }', LAST), "calls[1].pass"),
        ((FIRST, '{ station = "H", pass = "06:07" }', LAST), "calls[2].arrival"),
        ((FIRST, '{ station = "H", pass = "6:3" }', LAST), "calls[1].pass"),
        (('{ station = "A", pass = "06:01" }', LAST), "calls[0].pass"),
        ((FIRST, '{ station = "B", pass = "06:06" }'), "calls[1].pass"),
    ],
)
def test_what_a_passing_cannot_be(calls: Sequence[str], key: str) -> None:
    with pytest.raises(InputError) as found:
        parse_timetable(day(*calls), "day.toml", LINE)
    assert found.value.key == f"trains[0].{key}"


def without_platform(text: str) -> str:
    """The sample line with no platform anywhere at B."""
    low, high = text.split('id = "B"', 1)
    lines = high.replace("platform_from_km", "\0").splitlines()
    kept = [part if "\0" not in part else _cut(part) for part in lines]
    return low + 'id = "B"' + "\n".join(kept) + "\n"


def _cut(part: str) -> str:
    head, rest = part.split("\0", 1)
    return head + rest.split("platform_to_km", 1)[1].split(",", 1)[1]


def test_a_track_without_a_platform_is_for_trains_alone() -> None:
    line = parse_line(without_platform(SAMPLE), "line.toml")
    assert line.stations["B"].is_signal_station
    assert not line.stations["A"].is_signal_station
    with pytest.raises(InputError) as found:
        parse_timetable(day(FIRST, LAST), "day.toml", line)
    assert (found.value.key, "operational" in found.value.expected) == ("trains[0].calls[1].station", True)
    parse_timetable(day(FIRST, LAST.replace(" }", ", operational = true }")), "day.toml", line)
    parse_timetable(day(FIRST, LAST, revenue=False), "day.toml", line)


@pytest.mark.parametrize(("calls", "key"), [((FIRST, '{ station = "H", arrival = "06:05" }'), "calls[1]")])
def test_no_train_ends_where_it_has_no_track_of_its_own(calls: Sequence[str], key: str) -> None:
    with pytest.raises(InputError, match="this is a halt") as found:
        parse_timetable(day(*calls), "day.toml", LINE)
    assert found.value.key == f"trains[0].{key}.station"
