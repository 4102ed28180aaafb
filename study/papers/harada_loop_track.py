"""`branchline reproduce harada-loop-track`: a train is sent over the loop, and its map has the main track alone.

Harada, Maki, Kazato and Ishiguri, 3.5 and figure 4: the points and the curves beside them make the least sum of squares
(equation 3) rise; while it is over its threshold no fix is taken and the wheels alone carry the position on, and after
the station all is as before. The unit here goes by a timetable that has the train pass on the main track.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from network.model import Line
from onboard import notes
from onboard.localisation.fix import FOREIGN, TAKEN
from simulation.sensor_settings import Curvature
from study.papers.harada_bench import Ride, Trip, turning
from study.papers.harada_chart import write_watched
from study.papers.harada_watch import Watch
from study.papers.mountain_line import ASSUMED, MountainLine, mountain_line
from study.papers.parameter_sets import LINE
from study.papers.reproduction import NullMethod, Options, Parameter, Reproduction, Row

STATIONS: Final = 4
AT: Final = 2  # the third station
SLOW_KMH: Final = 45.0
NULL: Final = NullMethod("no threshold on the mismatch (equation 3)", ("fixes on the loop",))
NO_THRESHOLD_PER_M: Final = 0.01  # the greatest that a file may say: no track bends so
AROUND_M: Final = 250.0
BEFORE_M: Final = 700.0
AFTER_M: Final = 3500.0
RIGHT_M: Final = 2.0
NOTICED_WITHIN_M: Final = 300.0  # of the first leg: as in figure 4, while the points are in the run's data


@dataclass(frozen=True, slots=True)
class Loop:
    """The run over the loop; kilometrages (m) of its first and last leg's ends."""

    ride: Ride
    watched: Watch
    from_m: float
    to_m: float

    @property
    def noticed(self) -> list[float]:
        """How far from the first leg's beginning the track counted as foreign (m)."""
        return [
            at_m - self.from_m
            for at_m, _ in self.ride.noted(notes.ForeignTrack)
            if self.from_m <= at_m <= self.to_m + AFTER_M
        ]

    @property
    def fixes_inside(self) -> int:
        """Looks on the loop at which the last thing told of curvature is a fix taken.

        Counted from where it was noticed; where it never was, from where it had to be at the latest.
        """
        behind_m = self.noticed[0] if self.noticed else NOTICED_WITHIN_M
        rows = self.watched.between(self.from_m + behind_m, self.to_m)
        return int(np.count_nonzero(rows["outcome"] == TAKEN))

    def worst_m(self, from_m: float, to_m: float) -> float:
        """Greatest error of a stretch, m."""
        return float(np.abs(self.watched.between(from_m, to_m)["error_m"]).max())

    @property
    def right_again_m(self) -> float:
        """How far behind the last leg the estimate is within 2 m for good, m."""
        rows = self.watched.between(self.to_m, self.watched.to_m)
        off = np.flatnonzero(np.abs(rows["error_m"]) > RIGHT_M)
        if off.size == 0:
            return 0.0
        at = int(off[-1]) + 1
        return float(rows["true_m"][at] - self.to_m) if at < rows.size else float("inf")


def legs_of(line: Line, place_m: float) -> tuple[float, float]:
    """Where the loop of the station at `place_m` leaves the main track and meets it again, kilometrages (m)."""
    legs = [line.pieces[points.reverse_piece] for points in line.points.values()]
    near = [leg for leg in legs if abs(leg.from_m - place_m) < AROUND_M]
    return min(leg.from_m for leg in near), max(leg.to_m for leg in near)


def slowed(place: MountainLine, station: int) -> MountainLine:
    """The same line with the speed of diverging legs all through a station: what its signals ask of the train."""
    at_m = place.places_m[station]
    alignment = dict(place.tables["alignments"][0])
    limit = {
        "from_km": (at_m - AROUND_M) / 1000.0,
        "to_km": (at_m + AROUND_M) / 1000.0,
        "speed_kmh": SLOW_KMH,
    }
    alignment["limits"] = [*alignment.get("limits", []), limit]
    return place.with_tables(alignments=[alignment])


def run_loop(place: MountainLine, seed: int, settings: Curvature | None = None, *, sent: bool = True) -> Loop:
    """The run over the loop of the third station; with `sent` off it stays on the main track."""
    curvature = settings or Curvature()
    here = slowed(place, AT)
    from_m, to_m = legs_of(here.line, here.places_m[AT])
    watched = Watch(from_m - BEFORE_M, to_m + AFTER_M, curvature.mismatch_per_m)
    over = (here.station_ids[AT],) if sent else ()
    trip = Trip(here, seed=seed, curvature=curvature, timetable=here.timetable(over), told=here.timetable())
    return Loop(trip.run(watched.moments()), watched, from_m, to_m)


def rows_of(loop: Loop, straight: Loop) -> tuple[Row, ...]:
    """What figure 4 shows, beside ours; and the same run on the main track, where nothing may be noticed."""
    noticed = [round(away_m) for away_m in loop.noticed]
    foreign = int((loop.watched.between(loop.from_m, loop.to_m)["outcome"] == FOREIGN).sum())
    return (
        Row(
            "entering the loop is noticed",
            "the mismatch passes its threshold soon after the points (figure 4)",
            {"behind the toe_m": noticed},
            bool(noticed) and noticed[0] <= NOTICED_WITHIN_M,
            f"within {NOTICED_WITHIN_M:g} m",
        ),
        Row(
            "fixes on the loop",
            "none: the wheels alone",
            {"fixes": loop.fixes_inside, "looks of 10 m at a foreign track": foreign},
            loop.fixes_inside == 0,
            "none once it is noticed",
        ),
        Row(
            "worst error on the loop, m",
            None,
            round(loop.worst_m(loop.from_m, loop.to_m), 2),
            loop.worst_m(loop.from_m, loop.to_m) <= RIGHT_M,
            "within 2 m: no wrong fix before it is noticed",
        ),
        Row(
            "right again after the station",
            "once the loop is out of the run's data (600 m)",
            {
                "behind the last points_m": round(loop.right_again_m, 1),
                "worst after_m": round(loop.worst_m(loop.to_m + AFTER_M - 1500.0, loop.to_m + AFTER_M), 2),
                "fixes again": "foreign"
                in [getattr(n, "after", "") for _, n in loop.ride.noted(notes.FixTaken)],
            },
            loop.right_again_m < AFTER_M - 1500.0
            and "foreign" in [getattr(n, "after", "") for _, n in loop.ride.noted(notes.FixTaken)],
            "fixes are taken again, and the error is within 2 m, within 2 km",
        ),
        Row(
            "the same train on the main track",
            "no mismatch",
            {"told": len(straight.noticed)},
            not straight.noticed,
            "nothing is noticed",
        ),
        Row(
            "truth out of the stated bounds",
            None,
            round(max(loop.ride.result.out_m, straight.ride.result.out_m), 3),
            max(loop.ride.result.out_m, straight.ride.result.out_m) <= 0.0,
            "never, in any step",
        ),
    )


def reproduce(options: Options) -> Reproduction:
    """Both runs; draws figure 4 below `options.out`."""
    place = mountain_line(stations=STATIONS)
    loop, straight = run_loop(place, options.seed), run_loop(place, options.seed, sent=False)
    no_threshold = Curvature().model_copy(update={"mismatch_per_m": NO_THRESHOLD_PER_M})
    without = rows_of(run_loop(place, options.seed, no_threshold), straight)
    rows = [
        replace(row, beside=other.ours) for row, other in zip(rows_of(loop, straight), without, strict=True)
    ]
    remarks = [
        "The path of the unit, and so its map, has the main track; the loop is as long, 4 m beside it.",
        "The error says nothing of the threshold: a fix here is an interval that grows with what map and run differ by,"
        " so those that are taken without it move nothing either. What equation 3 does is that the loop is noticed"
        " (without a threshold nothing could be) and that no fix is taken there.",
    ]
    if options.out is not None:
        marks = ((loop.from_m, loop.to_m, "on the loop"),)
        title = "A train on the loop, by a map of the main track"
        drawn = write_watched(loop.watched, marks, title, Path(options.out), "harada_loop_track")
        remarks.append("drawn: " + ", ".join(path.name for path in drawn))
    return Reproduction(
        "harada-loop-track",
        "A foreign track is noticed by the mismatch of curvature (Harada and others, 3.5, figure 4)",
        (
            Parameter("station", place.station_ids[AT], "", "any with curves around it"),
            Parameter("speed through it", SLOW_KMH, "km/h", "of diverging legs; the driver sees the signals"),
            Parameter(
                "mismatch that counts", Curvature().mismatch_per_m, "1/m (root mean square)", "[curvature]"
            ),
            *ASSUMED,
            *turning(),
            *LINE.parameters(),
        ),
        (*rows, *NULL.rows(without)),
        tuple(remarks),
        beside="no threshold",
        null=NULL,
    )
