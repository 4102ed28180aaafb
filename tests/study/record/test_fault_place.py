"""Where a fault is on the graph: a stretch of line, or the train that has it; what is nowhere has the whole line."""

from dataclasses import replace
from typing import Any

import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import CrossingClass, CrossingControl, LevelCrossing
from simulation.faults.table import FAULTS
from study.record.fault_place import TO_SEE_M, place_of_fault
from study.record.marks import MarkPlace

LINE = load_line(shipped_line("karasuyama"))
OGANE_M = LINE.stations["OGN"].position_m


def place(kind: str, target: str, **figures: Any) -> MarkPlace:  # noqa: ANN401 - of the kind's own fields
    return place_of_fault(FAULTS[kind](target=target, **figures), LINE, ("V1", "V2"))


def test_a_train_carries_its_fault_along() -> None:
    assert place("power_off", "V2") == MarkPlace(units=("V2",))
    assert place("cut", "V1 <-> block-manager") == MarkPlace(units=("V1",))


@pytest.mark.parametrize(
    ("kind", "target"), [("power_off", "OGN-W"), ("stuck", "OGN.11"), ("cut", "OGN-W -> *")]
)
def test_points_and_their_terminal_lie_where_their_points_are(kind: str, target: str) -> None:
    ((low_m, high_m),) = place(kind, target).stretches_m
    assert OGANE_M - 600.0 < low_m < high_m < OGANE_M
    pieces = [piece for piece in LINE.pieces.values() if piece.points_id == "OGN.11"]
    assert (low_m, high_m) == (min(p.from_m for p in pieces), max(p.to_m for p in pieces))


def test_a_tag_is_a_place_and_a_cut_cable_lies_between_stations() -> None:
    tag = next(iter(LINE.tags.values()))
    ((low_m, high_m),) = place("miss", str(tag.id)).stretches_m
    assert (low_m + high_m) / 2 == pytest.approx(tag.position_m) and high_m - low_m == TO_SEE_M
    low, high = sorted(LINE.stations.values(), key=lambda station: station.position_m)[:2]
    between = (low.position_m, high.position_m)
    assert place("cable_cut", f"{low.id} - {high.id}").stretches_m == (between,)


def test_a_dead_zone_has_its_length_and_the_manager_the_whole_line() -> None:
    section = next(section for section in LINE.sections.values() if "-" in section.id)
    pieces = [LINE.pieces[piece_id] for piece_id in section.piece_ids]
    ((low_m, high_m),) = place("dead_zone", section.id, length_m=250.0).stretches_m
    assert low_m == min(piece.from_m for piece in pieces) and high_m - low_m == 250.0
    assert place("power_off", "block-manager") == MarkPlace() == place("cable_cut", "*")


@pytest.mark.parametrize("kind", ["barriers_stuck", "lamps_dead", "crossing_undetected", "stalled_vehicle"])
def test_what_fails_at_a_crossing_is_where_the_crossing_is(kind: str) -> None:
    crossing = LevelCrossing(
        "C", "C", CrossingClass.BARRIERS, CrossingControl.RADIO, "HSK-OGN", 4900.0, 6.0, 8.0, 15.0, 20.0
    )
    line = replace(LINE, crossings={"C": crossing})
    found = place_of_fault(FAULTS[kind](target="C"), line, ("V1",))
    assert found == MarkPlace(stretches_m=((4900.0 - TO_SEE_M / 2, 4900.0 + TO_SEE_M / 2),))
