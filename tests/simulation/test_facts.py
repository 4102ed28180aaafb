"""What the checkers are told of line and trains."""

import math

import pytest

from simulation.facts import brake_of, edge_heights, true_limits
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


def test_a_limit_lies_on_the_edges_of_its_directions(karasuyama_setup: Setup) -> None:
    """55 km/h from 6.767 to 6.932 km, either way; 30 km/h from 20.104 to 20.304 km, down; the EV-E301 runs 100 km/h."""
    line, limits = karasuyama_setup.line, true_limits(karasuyama_setup, ["V1"])
    found = {
        (round(3.6 * limit.speed_mps), edge[-1], round(at_m), round(end_m))
        for edge, on_it in limits.on_edges.items()
        for limit in on_it
        for piece in [line.pieces[edge[:-1]]]
        for at_m, end_m in [
            (piece.from_m + limit.from_m, piece.from_m + limit.to_m)
            if edge.endswith("+")
            else (piece.to_m - limit.from_m, piece.to_m - limit.to_m)
        ]
        if math.isfinite(end_m)
    }
    assert {each for each in found if each[0] == 30} == {(30, "+", 20104, 20304)}
    assert found >= {(55, "+", 6767, 6932), (55, "-", 6932, 6767)}
    assert limits.tops_mps["V1"] <= 100 / 3.6
    diverging = {points.reverse_piece + sign for points in line.points.values() for sign in "+-"}
    assert {edge for edge, on_it in limits.on_edges.items() if on_it[-1].to_m == math.inf} == diverging
