"""Timetables of two or three trains that meet, follow and turn back, on a line whose stations are known by their kind.

Down trains take tracks 1 and up trains tracks 2, so that however late a train is, each has somewhere to go: the only
circle of trains that wait for each other is longer than the trains that there are. Where an end is a dead end, one
train a direction runs, and they pass each other at a loop.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from tests.system.chaos.draw import Draw
from tests.system.chaos.ground import Call, Planned

FIRST_S = 10 * 3600
AGAIN: Final = "BCD"  # after the number of the train that it follows


@dataclass(frozen=True, slots=True)
class Stop:
    """A station as trains see it; `run_s` is a slack running time from the stop before, `portal` lies beyond an end."""

    station: str
    run_s: int = 0
    tracks: int = 2
    portal: str = ""


TEST_LINE_STOPS: Final = (Stop("A", portal="PW"), Stop("B", run_s=120, portal="PE"))


def trains_on(stops: Sequence[Stop], draw: Draw) -> list[Planned]:
    """Two or three trains; `stops` in the direction DOWN."""
    dead_end = any(stop.tracks < 2 for stop in (stops[0], stops[-1]))
    down = 1 if dead_end else draw.whole(0, 3)
    up = 1 if dead_end else draw.whole(max(0, 2 - down), 3 - down)
    up_stops = mirrored(stops)
    trains = _one_way(stops, "down", down, draw.of("down"))
    trains += _one_way(up_stops, "up", up, draw.of("up"))
    if not dead_end and draw.chance(0.35):
        trains = _with_turn_back(trains, stops, draw.of("turn back"))
    return trains


def mirrored(stops: Sequence[Stop]) -> list[Stop]:
    runs = [0, *(stop.run_s for stop in reversed(stops[1:]))]
    return [replace(stop, run_s=run_s) for stop, run_s in zip(reversed(stops), runs, strict=True)]


def _one_way(stops: Sequence[Stop], direction: str, count: int, draw: Draw) -> list[Planned]:
    """Trains in one direction: the first may stand on the line at first, the last stay on it."""
    trains: list[Planned] = []
    departs_s = FIRST_S + draw.whole(0, 150)
    for i in range(count):
        stands = not stops[0].portal or (i == 0 and draw.chance(0.6))
        stays = not stops[-1].portal or (i == count - 1 and draw.chance(0.6))
        begins = "stabled" if stands else f"portal:{stops[0].portal}"
        ends = "stabled" if stays else f"portal:{stops[-1].portal}"
        number = f"{direction[0].upper()}{i + 1}"
        calls = _calls(stops, direction, departs_s, stands=stands, stays=stays, draw=draw)
        trains.append(Planned(f"K{number}", number, direction, begins, ends, calls))
        departs_s += draw.whole(120, 300)
    return trains


def _calls(
    stops: Sequence[Stop], direction: str, departs_s: int, *, stands: bool, stays: bool, draw: Draw
) -> tuple[Call, ...]:
    track = "1" if direction == "down" else "2"
    calls: list[Call] = []
    now_s = departs_s
    for k, stop in enumerate(stops):
        first, last = k == 0, k == len(stops) - 1
        now_s += stop.run_s
        dwell_s = draw.whole(25, 90)
        arrival_s = now_s - (dwell_s if first else 0)
        calls.append(
            Call(
                stop.station,
                track if stop.tracks > 1 else "1",
                None if first and stands else arrival_s,
                None if last and stays else now_s if first else now_s + dwell_s,
            )
        )
        now_s += 0 if first else dwell_s
    return tuple(calls)


def _with_turn_back(trains: list[Planned], stops: Sequence[Stop], draw: Draw) -> list[Planned]:
    """The last down train that stays on the line goes back and off it, if no up train stays where it must pass."""
    staying = [t for t in trains if t.direction == "down" and t.ends == "stabled"]
    if not staying or any(t.direction == "up" and t.ends == "stabled" for t in trains):
        return trains
    there = staying[-1]
    leaves_s = (there.calls[-1].arrival_s or 0) + draw.whole(120, 240)
    calls = _calls(mirrored(stops), "up", leaves_s, stands=True, stays=False, draw=draw)
    calls = (replace(calls[0], track="1"), *calls[1:])
    back = Planned(
        there.stock, f"{there.number}B", "up", f"from:{there.number}", f"portal:{stops[0].portal}", calls
    )
    turned = [replace(t, ends=f"becomes:{back.number}") if t is there else t for t in trains]
    return [*turned, back]


def there_and_back(trains: list[Planned], stops: Sequence[Stop], draw: Draw) -> list[Planned]:
    """Sets that stay on the line go back, and there again, up to three times; with dead ends both as often, if they
    can pass between; else one whose tracks at both ends are nobody else's in the end.
    """
    dead_end = any(stop.tracks < 2 for stop in (stops[0], stops[-1]))
    if dead_end and all(stop.tracks < 2 for stop in stops[1:-1]):
        return trains
    staying = [train for train in trains if train.ends == "stabled"]
    alone = [train for train in staying if all(other.direction == train.direction for other in staying)][-1:]
    legs = draw.whole(1, len(AGAIN))
    found: list[Planned] = []
    for train in trains:
        goes_on = train in (staying if dead_end else alone)
        found += _again(train, stops, legs, draw.of(train.number)) if goes_on else [train]
    return found


def _again(there: Planned, stops: Sequence[Stop], legs: int, draw: Draw) -> list[Planned]:
    """A train and those that its set goes on as."""
    found = [there]
    for leg in range(legs):
        before = found[-1]
        direction = "up" if before.direction == "down" else "down"
        way = stops if direction == "down" else mirrored(stops)
        stays = leg < legs - 1 or not way[-1].portal or draw.chance(0.5)
        leaves_s = (before.calls[-1].arrival_s or 0) + draw.whole(75, 160)
        calls = _calls(way, direction, leaves_s, stands=True, stays=stays, draw=draw)
        calls = (replace(calls[0], track=before.calls[-1].track), *calls[1:])
        number = f"{there.number}{AGAIN[leg]}"
        ends = "stabled" if stays else f"portal:{way[-1].portal}"
        found[-1] = replace(before, ends=f"becomes:{number}")
        found.append(Planned(there.stock, number, direction, f"from:{before.number}", ends, calls))
    return found
