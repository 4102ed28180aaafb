"""One train comes in at a time, by the truth: on the net of a loop, with trains placed by hand."""

import pytest

from simulation.judge.body import Body
from simulation.judge.entering import EntryWatch, TrackOverlap
from simulation.judge.log import Checker, Log
from tests.simulation.judge.stage import net

# From the west on track T1 (260 m) a train stops 200 m on, 60 m before points P2, which are 30 and 10 m long; from the
# east on T2 likewise before P1.
STOPS_M = 200.0


def _watch(overlap_m: float) -> tuple[EntryWatch, Log]:
    log = Log()
    tracks = {edge_id: TrackOverlap(STOPS_M, overlap_m) for edge_id in ("T1+", "T2-")}
    return EntryWatch(net(), tracks, {"P1", "P2"}, log), log


def _train(unit_id: str, edge_id: str, *sections: str) -> Body:
    body = Body(unit_id, 40.0, [edge_id])
    body.sections = frozenset(sections)
    return body


@pytest.mark.parametrize(("overlap_m", "found"), [(59.9, 0), (60.1, 1)])
def test_points_within_the_overlap_are_nobody_elses_while_a_train_comes_in(
    overlap_m: float, found: int
) -> None:
    watch, log = _watch(overlap_m)
    comes, other = _train("A", "T1+", "P1", "T1"), _train("B", "stem2-", "B", "P2")
    watch.moved(1.0, other, [comes, other])
    assert [v.checker for v in log.violations] == [Checker.ONE_COMES_IN] * found


def test_it_comes_in_from_the_points_before_the_track_until_it_stands_with_all_its_length() -> None:
    watch, log = _watch(100.0)
    other = _train("B", "stem2-", "B", "P2")
    before = _train("A", "normal1+", "P1")
    watch.moved(1.0, before, [before, other])
    assert len(log.violations) == 1
    watch, log = _watch(100.0)
    half, whole = _train("A", "T1+", "P1", "T1"), _train("A", "T1+", "T1")
    watch.stands(half)  # its rear is still on the points
    watch.moved(2.0, other, [half, other])
    assert len(log.violations) == 1
    watch, log = _watch(100.0)
    watch.stands(whole)
    watch.moved(3.0, other, [whole, other])
    assert log.violations == ()


def test_who_left_the_track_and_comes_again_comes_in_anew() -> None:
    watch, log = _watch(100.0)
    other = _train("B", "stem2-", "B", "P2")
    watch.stands(_train("A", "T1+", "T1"))
    away, back = _train("A", "stem1-", "P1", "W"), _train("A", "T1+", "P1", "T1")
    watch.moved(1.0, away, [away])
    watch.moved(2.0, back, [back, other])
    assert len(log.violations) == 1


def test_a_line_without_overlaps_is_not_watched() -> None:
    assert not _watch(0.0)[0].watches
    assert not _watch(60.0)[0].watches  # no points begin within that
