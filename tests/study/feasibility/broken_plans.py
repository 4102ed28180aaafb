"""Good plans, each broken in one named way, with what the check is to find: who, where, in which minute, of which kind.

The plan that is broken: three sets on the busy line (six stations of two tracks, 6.6 km apart, 7 min a hop, 1 min a
stop). D goes down from the portal at Asahi, becomes U, and goes back up and off; V comes from the other end and meets D
at Edogawa and W at Izumi; W follows D 32 minutes behind and stays at Kasumi.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from network.files.line_file import load_line
from network.model import Coverage, Direction, Line, TagPurpose
from simulation.settings import Operation
from study.feasibility.finding import FindingKind
from tests.study.feasibility.plans import Plan, busy_line, call_at, later, with_call
from tests.system.chaos.ground import Call, Planned

STATIONS: Final = ("ASA", "IZU", "USU", "EDO", "OKA", "KAS")
HOP_S: Final = 8 * 60
STOP_S: Final = 60
TEN: Final = 10 * 3600


@dataclass(frozen=True)
class Broken:
    """A broken plan, and its fault. `runs` is false where it cannot even be tried."""

    plan: Plan
    kind: FindingKind
    trains: frozenset[str]
    place: str
    minute: str
    runs: bool = True


def journey(
    stock: str,
    number: str,
    direction: str,
    leaves_s: int,
    begins: str,
    ends: str,
    tracks: Sequence[str],
    stations: Sequence[str] = STATIONS,
) -> Planned:
    """A train along the busy line; `leaves_s` is when it leaves its first station."""
    stops = list(stations) if direction == "down" else list(reversed(stations))
    calls: list[Call] = []
    for k, (station, track) in enumerate(zip(stops, tracks, strict=True)):
        leaves = leaves_s + HOP_S * k
        comes = not (k == 0 and not begins.startswith("portal"))
        goes = not (k == len(stops) - 1 and not ends.startswith("portal"))
        calls.append(Call(station, track, leaves - STOP_S if comes else None, leaves if goes else None))
    return Planned(stock, number, direction, begins, ends, tuple(calls))


def good() -> Plan:
    """The plan before it is broken."""
    down, up = "111111", "222222"
    return Plan(
        busy_line(),
        (
            journey("S1", "D", "down", TEN, "portal:ASA.P", "becomes:U", down),
            journey("S1", "U", "up", TEN + 2 * 3600, "from:D", "portal:ASA.P", "122222"),
            journey("S2", "V", "up", TEN + HOP_S, "portal:KAS.P", "portal:ASA.P", up),
            journey("S3", "W", "down", TEN + 32 * 60, "portal:ASA.P", "stabled", "111112"),
        ),
    )


def opposing_between_stations() -> Broken:
    """V leaves Oka four minutes early, towards D."""
    plan = good()
    return _broken(
        plan.with_train(later(plan.train("V"), -4 * 60)), FindingKind.OPPOSING, "DV", "USU-EDO", "10:21"
    )


def one_track_for_both() -> Broken:
    """V is to meet D at Edogawa on D's track."""
    plan = good()
    changed = with_call(plan.train("V"), "EDO", track="1")
    return _broken(plan.with_train(changed), FindingKind.TRACK, "DV", "EDO", "10:23")


def follows_too_soon() -> Broken:
    """W leaves Asahi four minutes behind D, on the other tracks."""
    plan = good()
    train = journey("S3", "W", "down", TEN + 4 * 60, "portal:ASA.P", "stabled", "222222", STATIONS)
    return _broken(
        replace(plan, trains=tuple(t for t in plan.trains if t.number in "DU")).with_train(train),
        FindingKind.FOLLOWING,
        "DW",
        "ASA-IZU",
        "10:04",
    )


def terminal_occupied() -> Broken:
    """W ends on the track where D's set waits to turn back."""
    plan = good()
    changed = with_call(plan.train("W"), "KAS", track="1")
    return _broken(plan.with_train(changed), FindingKind.TERMINAL, "DW", "KAS", "11:11")


def stabled_for_the_night() -> Broken:
    """A last train is to come to the track where W's set stays."""
    plan = good()
    last = journey("S4", "X", "down", TEN + 5 * 3600, "portal:ASA.P", "stabled", "111112")
    return _broken(plan.with_train(last), FindingKind.TERMINAL, "WX", "KAS", "15:39")


def two_sets_stabled_on_one_track() -> Broken:
    """Two sets are to stand on one track before they begin."""
    plan = good()
    first, second = (
        journey(stock, number, "up", TEN + hours * 3600, "stabled", "portal:ASA.P", "222222")
        for stock, number, hours in (("S5", "Y", 6), ("S6", "Z", 7))
    )
    without = replace(plan, trains=tuple(t for t in plan.trains if t.number in "DU"))
    both = without.with_train(first).with_train(second)
    return _broken(both, FindingKind.TERMINAL, "YZ", "KAS", "16:00")


def leg_in_two_minutes() -> Broken:
    """6.6 km in two minutes."""
    plan = good()
    changed = later(plan.train("W"), -5 * 60, "OKA")
    return _broken(plan.with_train(changed), FindingKind.LEG, "W", "EDO-OKA", "10:56")


def turns_back_at_once() -> Broken:
    """D becomes U in the minute in which it comes, where the driver takes two to the other end."""
    plan = good()
    comes_s = call_at(plan.train("D"), "KAS").arrival_s or 0
    earlier = comes_s - (TEN + 2 * 3600)
    moved = later(plan.train("U"), earlier)
    slow = plan.operation.model_copy(update={"change_ends_s": 120.0})
    alone = replace(plan, trains=(plan.train("D"), moved), operation=slow)
    return _broken(alone, FindingKind.TURN_BACK, "DU", "KAS", "10:39")


def stops_for_no_time() -> Broken:
    """A stop of no time, where units keep a minute and a half."""
    plan = good()
    train = plan.train("W")
    arrival_s = call_at(train, "USU").arrival_s
    changed = with_call(train, "USU", departure_s=arrival_s)
    longer = replace(plan, dwell_min_s=90, trains=(changed,))
    return _broken(longer, FindingKind.DWELL, "W", "USU", "10:47")


def comes_back_at_once() -> Broken:
    """A set leaves by the portal and is to be back a minute later."""
    plan = good()
    up = plan.train("U")
    leaves_s = call_at(up, "ASA").departure_s or 0
    back = journey("S1", "B", "down", leaves_s + 2 * 60, "portal:ASA.P", "stabled", "111111")
    there = replace(plan, trains=(plan.train("D"), up, back))
    return _broken(there, FindingKind.LAYOVER, "UB", "ASA.P", "12:41")


def two_from_one_portal() -> Broken:
    """X is to come out of the portal half a minute behind D, onto the other track."""
    plan = good()
    behind = later(journey("S4", "X", "down", TEN, "portal:ASA.P", "stabled", "222222"), 30 * 60, "IZU")
    behind = with_call(behind, "ASA", arrival_s=TEN - STOP_S + 30)
    first = replace(plan.train("D"), ends="stabled")
    alone = replace(plan, trains=(first, behind), operation=Operation(portal_lead_s=100.0))
    return _broken(alone, FindingKind.PORTAL, "DX", "ASA.P", "09:57")


def sent_too_late() -> Broken:
    """Trains stand at the portal 10 s before they are to be at their first station."""
    plan = good()
    short = replace(plan, operation=Operation(portal_lead_s=10.0))
    return _broken(short, FindingKind.PORTAL, "D", "ASA.P", "09:59")


def sent_into_each_other() -> Broken:
    """X is sent to the portal while Y still stands on X's track and is to go out by that portal."""
    leaves_s = TEN + 5 * HOP_S
    out = journey("S1", "Y", "up", TEN, "stabled", "portal:ASA.P", "222221")
    comes = journey("S2", "X", "down", leaves_s + 4 * 60, "portal:ASA.P", "stabled", "111111")
    plan = Plan(busy_line(), (out, comes), operation=Operation(portal_lead_s=600.0))
    return _broken(plan, FindingKind.CIRCLE, "YX", "ASA.P", "10:41")


def no_tags() -> Broken:
    """No tag on the whole line."""
    line = busy_line()
    return _broken(replace(good(), line=replace(line, tags={})), FindingKind.TAG, "DW", "IZU", "10:07")


def no_approach_tag() -> Broken:
    """The approach and position tags before the points of Usui are gone."""
    line = busy_line()
    kept = {i: tag for i, tag in line.tags.items() if not _before_usui(line, i)}
    return _broken(replace(good(), line=replace(line, tags=kept)), FindingKind.TAG, "DW", "USU", "10:15")


def _before_usui(line: Line, tag_id: int) -> bool:
    tag = line.tags[tag_id]
    open_line = tag.piece_id == "IZU-USU" and tag.directions == (Direction.DOWN,)
    return open_line and tag.purpose in (TagPurpose.APPROACH, TagPurpose.POSITION, TagPurpose.DEPARTED)


def no_radio_at_a_station() -> Broken:
    """No radio from 500 m before Usui to 500 m behind it."""
    return _broken(
        replace(good(), line=_covered_without(12_700.0, 13_700.0)), FindingKind.COVERAGE, "DW", "USU", "10:15"
    )


def no_radio_before_points() -> Broken:
    """No radio between the approach tag of Usui's points and those."""
    line = _covered_without(11_500.0, 13_010.0)
    return _broken(replace(good(), line=line), FindingKind.COVERAGE, "DW", "USU", "10:15")


def no_way() -> Broken:
    """A track that ends in a buffer stop, and a train that is to run through it."""
    line = load_line(Path(__file__).with_name("stub.toml"))
    train = Planned(
        "S1",
        "T",
        "down",
        "stabled",
        "stabled",
        (
            Call("A", "1", None, TEN),
            Call("B", "2", TEN + 300, TEN + 360),
            Call("C", "1", TEN + 720, None),
        ),
    )
    return _broken(Plan(line, (train,)), FindingKind.NO_WAY, "T", "A", "10:00", runs=False)


def _covered_without(from_m: float, to_m: float) -> Line:
    """The busy line with radio everywhere but on one stretch."""
    line = busy_line()
    (alignment,) = line.alignments.values()
    covered = (Coverage(alignment.from_m, from_m), Coverage(to_m, alignment.to_m))
    return replace(line, alignments={alignment.id: replace(alignment, coverage=covered)})


def _broken(
    plan: Plan, kind: FindingKind, trains: str, place: str, minute: str, *, runs: bool = True
) -> Broken:
    return Broken(plan, kind, frozenset(trains), place, minute, runs)


BREAKS: Final[dict[str, Callable[[], Broken]]] = {
    make.__name__: make
    for make in (
        opposing_between_stations,
        one_track_for_both,
        follows_too_soon,
        terminal_occupied,
        stabled_for_the_night,
        two_sets_stabled_on_one_track,
        leg_in_two_minutes,
        turns_back_at_once,
        stops_for_no_time,
        comes_back_at_once,
        two_from_one_portal,
        sent_too_late,
        sent_into_each_other,
        no_tags,
        no_approach_tag,
        no_radio_at_a_station,
        no_radio_before_points,
        no_way,
    )
}
