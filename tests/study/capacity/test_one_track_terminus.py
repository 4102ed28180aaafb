"""A line whose termini have one track, by hand (docs/capacity.md): headways and compression exact to 0.1 s.

Asa, Mori with two tracks, Kawa: the example line at 47.52 km/h, its marks as far apart as a train of 60 m needs so that
each run is 3,000 m, however it turned. The train is the stone of `by_hand`, which moves a second after the word.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Final

import pytest

from scenario.scenario import load_scenario
from simulation.setup import Setup
from study.capacity import driven as driven_module
from study.capacity import legs as legs_module
from study.capacity import passage as passage_module
from study.capacity.compression import compressed
from study.capacity.headway import Headway, HeadwayKind, headways_of, kind_of_visit, visits_at
from study.capacity.legs import SetLeg, legs_of, places_of
from study.capacity.occupation import OccupationPart
from study.capacity.rules import MINIMAL
from study.capacity.theory import occupations
from tests.study.capacity.by_hand import STONE
from tests.study.capacity.test_held_up_by import RUNS, VALLEY, valley_times

SPEED_MPS: Final = 47.52 / 3.6 - 1.2  # the driver stays 1.2 m/s below: 12 m/s
PULL_MPS2: Final = 1.0
STOP_MPS2: Final = 0.6
RUN_M: Final = 3_000.0
SLOWS_S, SLOWS_M = SPEED_MPS / STOP_MPS2, SPEED_MPS**2 / (2.0 * STOP_MPS2)  # 20 s, 120 m
STARTS_S, STARTS_M = SPEED_MPS / PULL_MPS2, SPEED_MPS**2 / (2.0 * PULL_MPS2)  # 12 s, 72 m
SOFT_END_S: Final = 0.3**2 / (2.0 * STOP_MPS2 * 0.6)  # TASC eases to 0.3 m/s2 at 0.6 m/s3: 0.125 s
RUN_S: Final = STARTS_S + (RUN_M - STARTS_M - SLOWS_M) / SPEED_MPS + SLOWS_S + SOFT_END_S  # 266.1 s
START_S: Final = 1.0
RADIO_S: Final = 0.1  # each telegram
ASK_S: Final = 2 * RADIO_S
POINTS_S: Final = RADIO_S + 6.0 + RADIO_S
AT_ASA_S: Final = 60.0 + ASK_S + START_S  # a turn: ends changed, let into its way: 61.2 s
AT_KAWA_S: Final = 2 * RADIO_S + AT_ASA_S  # first what it gives back as it stands there: 61.4 s
SETS_OUT_S: Final = ASK_S + POINTS_S + START_S  # from a station with points: 7.4 s


def to_mark_s(left_m: float) -> float:
    """From a place on the way to the mark so far ahead, which is the last of a run."""
    if left_m > SLOWS_M:
        return SLOWS_S + (left_m - SLOWS_M) / SPEED_MPS + SOFT_END_S
    return math.sqrt(2.0 * left_m / STOP_MPS2) + SOFT_END_S


# The way is given back at the arrival tag, where that lies a train's length behind its end; the points of Mori, and
# all at Kawa, as it stands. Tags at 0.080 and 3.070 (up), 2.930 and 5.900 (down); marks -0.040, 2.960, 3.020, 6.020.
TO_ASA_S, TO_KAWA_S = RUN_S - to_mark_s(120.0), RUN_S - to_mark_s(120.0)
UP_TO_MORI_S, DOWN_TO_MORI_S = RUN_S - to_mark_s(110.0), RUN_S - to_mark_s(90.0)

F, DA, AD = HeadwayKind.FOLLOWING, HeadwayKind.DEPARTURE_ARRIVAL, HeadwayKind.ARRIVAL_DEPARTURE
THERE_S: Final = SETS_OUT_S + RUN_S  # from Mori to a terminus, from the request on
BACK_S: Final = RUN_S + RADIO_S  # and until it stands at Mori and has given back its points
BY_HAND: Final = {
    ("KWA", DA, "up, KWA.1", "down, KWA.1"): BACK_S + THERE_S,  # 539.8
    ("KWA", F, "up, KWA.1", "up, KWA.1"): BACK_S + THERE_S + AT_KAWA_S,  # 601.2
    ("ASA", DA, "down, ASA.1", "up, ASA.1"): BACK_S + THERE_S,
    ("ASA", F, "down, ASA.1", "down, ASA.1"): BACK_S + THERE_S + AT_ASA_S,  # 601.0
    ("MRI", AD, "down, MRI.1", "up, MRI.2"): RADIO_S + SETS_OUT_S,  # 7.5
    ("MRI", AD, "up, MRI.2", "down, MRI.1"): RADIO_S + SETS_OUT_S,
    # the first goes there and comes back before the second may go there: 601.2 and 601.0
    ("MRI", F, "down, MRI.1", "down, MRI.1"): RUN_S + AT_KAWA_S + BACK_S + SETS_OUT_S,
    ("MRI", F, "up, MRI.2", "up, MRI.2"): RUN_S + AT_ASA_S + BACK_S + SETS_OUT_S,
    # then the second goes there and comes back: 1,194.8 and 1,194.4
    ("MRI", DA, "down, MRI.1", "up, MRI.2"): 2 * (RUN_S + AT_KAWA_S) + BACK_S + SETS_OUT_S + RUN_S,
    ("MRI", DA, "up, MRI.2", "down, MRI.1"): 2 * (RUN_S + AT_ASA_S) + BACK_S + SETS_OUT_S + RUN_S,
    # onto the track that the first leaves, let into the way there as it starts: 513.4
    ("MRI", DA, "down, MRI.1", "down, MRI.1"): TO_KAWA_S + RADIO_S + ASK_S + START_S + RUN_S,
    ("MRI", DA, "up, MRI.2", "up, MRI.2"): TO_ASA_S + RADIO_S + ASK_S + START_S + RUN_S,
}
# From Mori to Kawa: 2 comes out, 1 goes in and comes out as 4, 3 goes in and comes out as 6, 5 goes in: 1,743.4 s.
KAWA_PART_S: Final = (ASK_S + START_S + BACK_S) + 2 * (THERE_S + AT_KAWA_S + BACK_S) + (THERE_S + RADIO_S)
# The track of Asa: 1 goes out, 2 and 4 come in and go out, 6 comes in, last of all, until it stands: 1,690.5 s.
FREES_ASA_S: Final = DOWN_TO_MORI_S + RADIO_S
ASA_TRACK_S: Final = (ASK_S + START_S + FREES_ASA_S) + 2 * (THERE_S + AT_ASA_S + FREES_ASA_S) + THERE_S


@pytest.fixture(scope="module")
def setup(tmp_path_factory: pytest.TempPathFactory) -> Setup:
    folder = tmp_path_factory.mktemp("terminus")
    line = (VALLEY / "valley.toml").read_text("utf-8")
    changes = {"max_speed_kmh = 70": "max_speed_kmh = 47.52", "limit_kmh = 45": "limit_kmh = 47.52"}
    changes |= {f"mark_up_km = {km - 0.02:.2f}": f"mark_up_km = {km - 0.04:.2f}" for km in (0.0, 3.0, 6.0)}
    laid = '{{ id = {}, section = "ASA.1", km = 0.{}, purpose = "{}"'
    changes[laid.format(103, "080", "position")] = laid.format(103, "080", "arrival")
    changes[laid.format(104, "100", "arrival")] = laid.format(104, "100", "position")
    for before, after in changes.items():
        assert before in line
        line = line.replace(before, after)
    (folder / "valley.toml").write_text(line, "utf-8")
    last = ("6", "3", "stabled", "up", ("KWA", "10:41"), ("ASA", "10:50:30"))
    (folder / "valley_times.toml").write_text(valley_times((*RUNS[:-1], last)), "utf-8")
    starts = STONE.replace('"traction.dead_time_s" = 0.0', f'"traction.dead_time_s" = {START_S}')
    day = (VALLEY / "valley_day.toml").read_text("utf-8")
    air = f"[air]\ndelay_min_s = {RADIO_S}\ndelay_mean_s = {RADIO_S}\n"
    loads = "load_share_mean = 0.0\nload_share_spread = 0.0\n"
    text = f'{day}\n{loads}\n{air}\n{starts}"body.length_m" = 60.0\n'
    (folder / "valley_day.toml").write_text(text, "utf-8")
    return load_scenario(str(folder / "valley_day.toml")).setup


def legs(setup: Setup) -> tuple[SetLeg, ...]:
    return legs_of(occupations(setup, MINIMAL), places_of(setup.line))


def pairs(setup: Setup) -> Iterator[tuple[tuple[str, HeadwayKind, str, str], Headway]]:
    """Every headway that two trains of the day keep in this order, the last ones too."""
    for station in setup.line.stations.values():
        visits = visits_at(legs(setup), frozenset(track.section_id for track in station.tracks))
        for at, first in enumerate(visits):
            for second in visits[at + 1 :]:
                for one in headways_of(first, second, setup.unit.dwell_min_s):
                    if one.planned_s > 0.0:
                        yield (station.id, one.kind, kind_of_visit(first), kind_of_visit(second)), one


def off(setup: Setup) -> set[tuple[str, HeadwayKind, str, str]]:
    """Where a headway is not what the hand says: to 0.1 s, of all pairs."""
    return {key for key, one in pairs(setup) if abs(one.least_s - BY_HAND.get(key, math.inf)) > 0.1}


def occupied_s(setup: Setup) -> Sequence[float]:
    """The single track to Kawa with its terminus, and the track of Asa alone."""
    parts = (frozenset({"MRI.E", "MRI-KWA", "KWA.1"}), frozenset({"ASA.1"}))
    return [compressed(legs(setup), part).occupied_s for part in parts]


def test_headways_by_hand(setup: Setup) -> None:
    assert {key for key, _ in pairs(setup)} == set(BY_HAND)
    assert off(setup) == set()


def test_compression_by_hand(setup: Setup) -> None:
    assert occupied_s(setup) == pytest.approx([KAWA_PART_S, ASA_TRACK_S], abs=0.1)


def test_without_the_soft_end_of_a_stop(setup: Setup, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(driven_module, "SOFT_END_COUNTS", False)
    assert occupied_s(setup)[0] == pytest.approx(KAWA_PART_S - 6 * SOFT_END_S, abs=0.1)
    assert ("KWA", DA, "up, KWA.1", "down, KWA.1") in off(setup)


def test_without_the_last_stand(setup: Setup, monkeypatch: pytest.MonkeyPatch) -> None:
    """The last train would have come as its front is past the joint, 190 m before its mark."""
    monkeypatch.setattr(passage_module, "LAST_STANDS", False)
    assert off(setup) == {("ASA", DA, "down, ASA.1", "up, ASA.1")}
    assert occupied_s(setup)[1] == pytest.approx(ASA_TRACK_S - to_mark_s(190.0), abs=0.1)


@pytest.mark.parametrize(
    ("part", "takes_s"), [(OccupationPart.RELEASE, 2 * RADIO_S), (OccupationPart.START, START_S)]
)
def test_without_a_part_of_a_turn(
    setup: Setup, monkeypatch: pytest.MonkeyPatch, part: OccupationPart, takes_s: float
) -> None:
    monkeypatch.setattr(legs_module, "SLACK", legs_module.SLACK | {part})
    assert ("MRI", F, "down, MRI.1", "down, MRI.1") in off(setup)
    assert occupied_s(setup)[0] == pytest.approx(KAWA_PART_S - 2 * takes_s, abs=0.1)
