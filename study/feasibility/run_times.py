"""How long a kind of train takes from a stand to a stand, asked for many trains of a day that run the same ways.

The one formula is `study.measures.running_times.least_times_s`; here each way is asked for once, and as no
more than the track that it takes: what lies beyond its end, or further behind than the train is long, changes nothing.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right

from network.model import Line
from network.path import Path, path_of
from simulation.setup import Setup
from study.measures.running_times import RunWay, least_times_s


class RunTimes:
    """Running times of one setup's trains, with its mean load and the distance to limits that units keep, s."""

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self._known: dict[tuple[object, ...], tuple[float, ...]] = {}

    def run_s(
        self, stock_id: str, path: Path, from_m: float, to_m: float, *, at_limits: bool = False
    ) -> float:
        """From a stand at a path coordinate (m) of the front to a stand at another; infinite where it cannot climb.

        As trains are driven; `at_limits`: as fast as the limits allow, which no unit does.
        """
        return self.times_s(stock_id, path, from_m, to_m, (), at_limits=at_limits)[-1]

    def times_s(
        self,
        stock_id: str,
        path: Path,
        from_m: float,
        to_m: float,
        passing_m: tuple[float, ...],
        *,
        at_limits: bool = False,
    ) -> tuple[float, ...]:
        """The same to where the front passes each of `passing_m` (path coordinates), and to the stand."""
        kind = self._setup.trains[stock_id]
        length_m = float(kind.row[0]["length_m"])
        way = cut_way(self._setup.believed_line, path, from_m, to_m, length_m)
        driving = self._setup.driving
        below_mps = 0.0 if at_limits else driving.driving_margin_mps
        begins_m = from_m - way.from_m  # of the part that the way is
        at_m = tuple(round(position_m - begins_m, 3) for position_m in passing_m)
        key = (kind.id, way.path.piece_ids, round(way.from_m, 3), round(way.to_m, 3), at_m, below_mps)
        if key not in self._known:
            self._known[key] = least_times_s(
                kind,
                way,
                at_m,
                self._setup.load.load_share_mean,
                driving.stop_deceleration_mps2,
                below_mps,
            )
        return self._known[key]


def cut_way(line: Line, path: Path, from_m: float, to_m: float, length_m: float) -> RunWay:
    """A run on the part of its path that it needs."""
    first = bisect_right(path.steps, from_m - length_m - 1.0, key=lambda step: step.end_m)
    end = bisect_left(path.steps, to_m + 1.0, lo=first, key=lambda step: step.start_m)
    steps = path.steps[first:end]
    begin_m = steps[0].start_m
    part = path_of(line, [step.piece_id for step in steps], path.direction)
    return RunWay(line, part, from_m - begin_m, to_m - begin_m)
