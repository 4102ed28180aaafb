"""Six trains on three sections with one loop, from a line file and a timetable: the loop moved from L to M.

Line and times are not those of the hand calculation in docs/capacity.md, but its sum is: what a part takes is, round
the order of its trains, how long after each the next one can be let in; by theory's blocking times, two at a time.
"""

from itertools import pairwise
from pathlib import Path

import pytest

from exchange.new_line import NewLineOptions, write_line
from study.capacity.compression import compressed
from study.capacity.cut import PartKind, cut_of
from study.capacity.legs import SetLeg, legs_of, places_of
from study.capacity.occupation import Occupation, conflicts_of
from study.capacity.rules import MINIMAL
from study.capacity.theory import occupations
from tests.study.feasibility.plans import Plan
from tests.system.chaos.ground import Call, Planned

KM = {"A": 0.0, "L": 6.0, "M": 11.0, "B": 15.0}
RUN_S = {"A": 420, "L": 360, "M": 300}  # down, from the station on; planned with room
DWELL_S = {"L": 60, "M": 60}
# of 2 and 5: so that they meet 1 and 4 in the loop
STARTS_S = {"1": 36_000, "3": 39_600, "4": 43_200, "6": 46_800}


def train(number: str, starts_s: int, loop: str) -> Planned:
    """A train from end to end; down trains are on track 1, up trains on track 2, where there are two."""
    down = number in {"1", "3", "4"}
    stations = list(KM) if down else list(KM)[::-1]
    at_s, calls = starts_s, list[Call]()
    for place, station in enumerate(stations):
        track = "1" if down or station not in {"A", "B", loop} else "2"
        if place:
            at_s += RUN_S[min(stations[place - 1], station, key=lambda s: KM[s])]
        goes_s = None if place == 3 else at_s + (DWELL_S.get(station, 0) if place else 0)
        calls.append(Call(station, track, at_s if place else None, goes_s))
        at_s = at_s if goes_s is None else goes_s
    begins, ends = ("A.P", "B.P") if down else ("B.P", "A.P")
    return Planned(
        f"K{number}", number, "down" if down else "up", f"portal:{begins}", f"portal:{ends}", tuple(calls)
    )


def plan(loop: str, folder: Path) -> Plan:
    rows = [
        f"{s},{s},{km},{2 if s in {'A', 'B', loop} else 1},{'portal' if s in 'AB' else ''}"
        for s, km in KM.items()
    ]
    listed = folder / f"{loop}.csv"
    listed.write_text("\n".join(("id,name,km,tracks,end", *rows, "")), "utf-8")
    line = write_line(listed, folder / f"line_{loop.lower()}.toml", NewLineOptions(max_speed_kmh=85)).line
    to_s = {"L": RUN_S["A"], "M": RUN_S["A"] + DWELL_S["L"] + RUN_S["L"]}[loop]
    back_s = {"L": RUN_S["M"] + DWELL_S["M"] + RUN_S["L"], "M": RUN_S["M"]}[loop]
    starts_s = STARTS_S | {up: STARTS_S[down] + to_s - back_s for down, up in (("1", "2"), ("4", "5"))}
    return Plan(line, tuple(train(number, at_s, loop) for number, at_s in sorted(starts_s.items())))


def by_pairs_s(legs: tuple[SetLeg, ...], section_ids: frozenset[str]) -> float:
    """Round the order of trains: from each one's being let in to the next one's, by the two alone."""
    held: dict[str, dict[str, Occupation]] = {}
    for leg in legs:
        for one in leg.occupations:
            if one.section_id in section_ids:
                held.setdefault(leg.number, {})[one.section_id] = one
    let_in = {number: min(o.begin_s for o in own.values()) for number, own in held.items()}
    order = sorted(let_in, key=lambda number: let_in[number])
    return sum(
        max(
            (held[a][s].end_s - let_in[a]) - (held[b][s].begin_s - let_in[b])
            for s in held[a].keys() & held[b].keys()
        )
        for a, b in pairwise((*order, order[0]))
    )


def parts(loop: str, folder: Path) -> dict[str, float]:
    """What each part between crossing stations takes."""
    setup = plan(loop, folder).setup()
    made = occupations(setup, MINIMAL)
    assert conflicts_of(made) == ()
    legs = legs_of(made, places_of(setup.line))
    found: dict[str, float] = {}
    for part in cut_of(setup.line, "crossing").parts:
        assert part.kind is PartKind.LINE
        found[part.name] = compressed(legs, part.section_ids).occupied_s
        assert found[part.name] == pytest.approx(by_pairs_s(legs, part.section_ids), abs=0.1)
    return found


def test_the_loop_moved_changes_the_parts_as_the_sum_says(tmp_path: Path) -> None:
    at_l, at_m = parts("L", tmp_path), parts("M", tmp_path)
    assert list(at_l) == ["A - L", "L - B"]
    assert list(at_m) == ["A - M", "M - B"]
    assert at_l["A - L"] < at_m["A - M"]
    assert at_m["M - B"] < at_l["L - B"]
    assert max(at_m.values()) > max(at_l.values())
