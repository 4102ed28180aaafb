"""What the checkers are told of line and trains."""

from __future__ import annotations

import pytest

from simulation.facts import brake_of, edge_heights
from simulation.setup import Setup


def test_the_guaranteed_brake_is_that_of_the_train_as_it_is(karasuyama_setup: Setup) -> None:
    """The EV-E301's emergency brake gives 1.25 m/s^2 after 0.5 s and a lag of 0.4 s; four fifths are counted on."""
    brake = brake_of(karasuyama_setup, "V1")
    assert brake.deceleration_mps2 == pytest.approx(0.8 * 1.25)
    assert brake.reaction_s == pytest.approx(0.5 + 0.4 + 0.5)
    assert brake.gravity_mps2 < 9.81


def test_an_edge_lies_as_high_as_its_counterpart_seen_from_the_other_end(karasuyama_setup: Setup) -> None:
    heights = edge_heights(karasuyama_setup.line)
    assert set(heights) == {piece + sign for piece in karasuyama_setup.line.pieces for sign in "+-"}
    for piece in karasuyama_setup.line.pieces.values():
        down, up = heights[f"{piece.id}+"], heights[f"{piece.id}-"]
        assert (down[0][0], down[-1][0]) == pytest.approx((0.0, piece.length_m))
        assert [height_m for _, height_m in up] == [height_m for _, height_m in reversed(down)]
        assert [at_m for at_m, _ in up] == pytest.approx(
            [piece.length_m - at_m for at_m, _ in reversed(down)]
        )
