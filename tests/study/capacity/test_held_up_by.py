"""A little line of one's own (docs/make-a.md): what a headway is said to cost is what it moves by, and termini."""

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import pytest

from scenario.scenario import load_scenario
from simulation.setup import Setup
from study.capacity.compression import compressed
from study.capacity.headway import Headway, HeadwayKind, line_cases
from study.capacity.legs import legs_of, places_of, stand_of
from study.capacity.occupation import OccupationCost
from study.capacity.rules import MINIMAL
from study.capacity.theory import occupations
from tests.trains import day_of

VALLEY: Final = Path(__file__).parents[2] / "examples" / "line"
Run = tuple[str, str, str, str, tuple[str, str], tuple[str, str]]
# Two sets to and fro: they pass each other at Mori, and turn back at Asa and Kawa with a layover of ten minutes.
RUNS: Final[tuple[Run, ...]] = (
    ("1", "stabled", "4", "down", ("ASA", "10:00"), ("KWA", "10:09:30")),
    ("2", "stabled", "3", "up", ("KWA", "10:00"), ("ASA", "10:09:30")),
    ("3", "2", "6", "down", ("ASA", "10:20"), ("KWA", "10:29:30")),
    ("4", "1", "5", "up", ("KWA", "10:20"), ("ASA", "10:29:30")),
    ("5", "4", "stabled", "down", ("ASA", "10:40"), ("KWA", "10:49:30")),
    ("6", "3", "stabled", "up", ("KWA", "10:40"), ("ASA", "10:49:30")),
)


def valley_times(trains: Sequence[Run] = RUNS) -> str:
    head = '[timetable]\nid = "valley_times"\nline = "valley"\ndwell_min_s = 20\nassumed = ["all"]\n'
    track = {"down": "1", "up": "2"}
    made = [
        f"{number} {direction}, {before if before == 'stabled' else f'from:{before}'} to"
        f" {after if after == 'stabled' else f'becomes:{after}'}: {a} -/{at}; MRI {track[direction]}"
        f" {at[:3]}{int(at[3:]) + 4:02}/{at[:3]}{int(at[3:]) + 5:02}:30; {b} {by}/-"
        for number, before, after, direction, (a, at), (b, by) in trains
    ]
    return head + day_of(*made, S1="1 4 5", S2="2 3 6")


def _headways(
    folder: Path, line: Callable[[str], str] = str, more: str = ""
) -> dict[tuple[str, ...], Headway]:
    setup = _setup(folder, line, more)
    cases = line_cases(setup.line, occupations(setup, MINIMAL), setup.unit.dwell_min_s)
    return {(c.station_id, c.first, c.second, c.headway.kind.value): c.headway for c in cases}


def _setup(folder: Path, line: Callable[[str], str] = str, more: str = "") -> Setup:
    folder.mkdir(exist_ok=True)
    (folder / "valley.toml").write_text(line((VALLEY / "valley.toml").read_text("utf-8")), "utf-8")
    (folder / "valley_times.toml").write_text(valley_times(), "utf-8")
    day = (VALLEY / "valley_day.toml").read_text("utf-8")
    (folder / "valley_day.toml").write_text(f"{day}\n{more}", "utf-8")
    return load_scenario(str(folder / "valley_day.toml")).setup


def test_what_moves_a_headway_is_what_it_is_said_to_cost(tmp_path: Path) -> None:
    whole = _headways(tmp_path / "whole")
    half = _headways(tmp_path / "half", lambda text: re.sub(r"(throw_time_s =) 6.0", r"\1 3.0", text))
    slow = _headways(tmp_path / "slow", more="[air]\ndelay_min_s = 0.2\ndelay_mean_s = 0.2\n")
    assert set(whole) == set(half) == set(slow)
    moved = 0
    for key, one in whole.items():
        assert one.least_s - half[key].least_s == pytest.approx(
            one.costs_s[OccupationCost.POINTS] / 2.0, abs=1e-6
        ), key
        moved += one.costs_s[OccupationCost.POINTS] > 0.0
        # An arrival lies after the release of what led to it: that telegram is in the driving that counts negative.
        before_s = 0.1 if one.kind is HeadwayKind.ARRIVAL_DEPARTURE else 0.0
        radio_s = one.costs_s[OccupationCost.RADIO] + before_s
        assert slow[key].least_s - one.least_s == pytest.approx(radio_s, abs=1e-6), key
    assert moved >= 4


def test_opposing_departure_by_hand(tmp_path: Path) -> None:
    """A train of 60 m clears the points when it stands: release 0.1, request and grant 0.2, points 0.1 + 6 + 0.1,
    brake off 1.1 s.
    """
    found = _headways(tmp_path, more='[patch.train.ev_e301.set]\n"body.length_m" = 60.0\n')
    meets = [one for one in found.values() if one.kind is HeadwayKind.ARRIVAL_DEPARTURE]
    assert len(meets) == 2
    assert [one.least_s for one in meets] == pytest.approx([7.6, 7.6], abs=0.05)


def test_a_layover_is_no_traffic_of_a_terminus(tmp_path: Path) -> None:
    setup = _setup(tmp_path)
    legs = legs_of(occupations(setup, MINIMAL), places_of(setup.line))
    found = compressed(legs, frozenset({"ASA.1"}))
    assert set(found.trains) == {"1", "2", "3", "4", "5", "6"}
    held = {id(one): one for leg in legs for one in leg.held if one.section_id == "ASA.1"}.values()
    turns = [one for one in held if one.number in {"2", "4"}]
    assert len(turns) == 2
    by_hand_s = 0.0
    for one in turns:
        stand = stand_of(one)
        by_hand_s += one.length_s - (stand.departs_s - stand.arrives_s) + stand.least_s
        assert stand.departs_s - stand.arrives_s > 600.0 > 100.0 > stand.least_s
    first = next(one for one in held if one.number == "1")
    last = next(one for one in held if one.number == "6")
    out = next(leg for leg in legs if leg.number == "1")
    by_hand_s += first.end_s - min(one.begin_s for one in out.occupations)
    by_hand_s += stand_of(last).arrives_s - last.begin_s
    assert found.occupied_s == pytest.approx(by_hand_s, abs=0.1)
