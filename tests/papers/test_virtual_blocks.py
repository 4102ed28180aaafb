"""Virtual blocks on a branch line: what the gain is, that a row can fail, and at night what `--quick` runs."""

from dataclasses import replace
from pathlib import Path

import pytest

from papers import virtual_blocks
from papers.reproduction import Options
from papers.virtual_blocks import BlocksCurve, BlocksPoint
from study.capacity.shared_stretch import StretchHeadways, traffic_at


def curve(following_s: dict[int, float]) -> BlocksCurve:
    def point(blocks: int, apart_s: float) -> BlocksPoint:
        stretch = StretchHeadways((apart_s, apart_s), (10.0, 10.0), (900.0, 900.0))
        return BlocksPoint(blocks, stretch, traffic_at(stretch, 600.0, 1))

    points = tuple(point(*one) for one in following_s.items())
    return BlocksCurve(
        "made_up", "Made up", 600.0, points, (point(1, 1800.0), point(points[-1].blocks, 1800.0))
    )


def test_closer_followers_are_more_trains_and_a_line_without_them_fails_the_row() -> None:
    gains, none = curve({1: 900.0, 5: 220.0, 80: 80.0}), curve({1: 900.0, 5: 880.0, 80: 200.0})
    assert gains.gain_percent(1) == 0.0
    assert 0.0 < gains.gain_percent(5) < gains.gain_percent(80)
    assert gains.share_percent(5) > 50.0 > none.share_percent(5)
    rows = virtual_blocks.rows_of(none)
    assert [row.passed for row in rows] == [True, False]


def test_blocks_of_routes_had_whole_must_not_gain_as_much() -> None:
    """The null method's trains run on the cut line; were they to gain by it, the idea would have no part in that."""
    none = curve({1: 900.0, 5: 220.0, 80: 80.0})
    (low,) = virtual_blocks.reproduce.null.rows([virtual_blocks.gain_row(virtual_blocks.without_idea(none))])
    assert low.passed
    gaining = replace(none, had_whole=(none.had_whole[0], none.points[-1]))
    (high,) = virtual_blocks.reproduce.null.rows(
        [virtual_blocks.gain_row(virtual_blocks.without_idea(gaining))]
    )
    assert not high.passed


def test_trains_that_cross_have_a_track_each() -> None:
    """Standard paths take one track both ways; who departs would then have come there after the other: 126 s more."""
    found = virtual_blocks.curve_of("busy_line", (1,), 1)
    down_s, up_s = found.points[0].stretch.meeting_s
    assert down_s == pytest.approx(up_s, abs=1.0)
    assert down_s < 0.0  # the way out is set while the other still runs in


def test_the_picture(tmp_path: Path) -> None:
    drawn = virtual_blocks.chart([curve({1: 900.0, 5: 220.0, 80: 80.0})])
    assert [path.name for path in drawn.write(tmp_path)] == ["virtual_blocks.svg", "virtual_blocks.png"]


@pytest.mark.nightly
def test_five_blocks_give_most_of_what_moving_blocks_do() -> None:
    found = virtual_blocks.reproduce(Options(quick=True))
    assert found.passed
    gained, of_five, without = found.rows
    assert not gained.case.startswith("null method")
    assert of_five.criterion == "more than half"
    assert without.case == virtual_blocks.reproduce.null.case(gained.case)
