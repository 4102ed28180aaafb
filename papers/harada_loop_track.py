"""`branchline reproduce harada-loop-track`: a train is sent over the loop, and its map has the main track alone.

Harada, Maki, Kazato and Ishiguri, 3.5 and figure 4: the points and the curves beside them make the least sum of squares
(equation 3) rise; while it is over its threshold no fix is taken and the wheels alone carry the position on, and after
the station all is as before. The unit here goes by a timetable that has the train pass on the main track.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from network.model import Line
from onboard import notes
from onboard.localisation.fix import FOREIGN, TAKEN
from papers.harada_bench import SHARED, PlannedTrip, TripRun, Watch, bounds_row
from papers.mountain_line import MountainLine, mountain_line
from papers.parameter_sets import LINE
from papers.reproduction import CaseRow, NullMethod, Options, Parameter
from papers.specification import Findings, Specification
from simulation.sensor_settings import Curvature

STATIONS: Final = 4
AT: Final = 2  # the third station
SLOW_KMH: Final = 45.0
NO_THRESHOLD_PER_M: Final = 0.01  # the greatest that a file may say: no track bends so
AROUND_M: Final = 250.0
BEFORE_M: Final = 700.0
AFTER_M: Final = 3500.0
RIGHT_M: Final = 2.0
NOTICED_WITHIN_M: Final = 300.0  # of the first leg: as in figure 4, while the points are in the run's data
FIXES: Final = "fixes on the loop"


@dataclass(frozen=True, slots=True)
class Loop:
    """The run over the loop; kilometrages (m) of its first and last leg's ends."""

    ride: TripRun
    watched: Watch
    from_m: float
    to_m: float

    @property
    def noticed(self) -> list[float]:
        """How far from the first leg's beginning the track counted as foreign (m)."""
        return [at_m - self.from_m for at_m in self.ride.foreign_at_m(self.from_m, self.to_m + AFTER_M)]

    @property
    def fixes_inside(self) -> int:
        """Looks on the loop at which the last note of curvature is a fix that was used.

        Counted from where it was noticed, or had to be at the latest.
        """
        behind_m = min([*self.noticed, NOTICED_WITHIN_M])
        rows = self.watched.moments_between(self.from_m + behind_m, self.to_m)
        return int(np.count_nonzero(rows["outcome"] == TAKEN))

    def rows(self, straight: Loop) -> tuple[CaseRow, ...]:
        """What figure 4 shows, beside ours; and the same run on the main track, where nothing may be noticed."""
        watched, noticed = self.watched, [round(away_m) for away_m in self.noticed]
        foreign = int((watched.moments_between(self.from_m, self.to_m)["outcome"] == FOREIGN).sum())
        worst_m = watched.worst_m(self.from_m, self.to_m)
        last_m = watched.worst_m(self.to_m + AFTER_M - 1500.0, self.to_m + AFTER_M)
        again_m = watched.within_from_m(self.to_m, RIGHT_M) - self.to_m
        again = "foreign" in [getattr(note, "after", "") for _, note in self.ride.notes_of(notes.FixTaken)]
        return (
            CaseRow(
                "entering the loop is noticed",
                "the mismatch passes its threshold soon after the points (figure 4)",
                {"behind the toe_m": noticed},
                bool(noticed) and noticed[0] <= NOTICED_WITHIN_M,
                f"within {NOTICED_WITHIN_M:g} m",
            ),
            CaseRow(
                FIXES,
                "none: the wheels alone",
                {"fixes": self.fixes_inside, "looks of 10 m at a foreign track": foreign},
                self.fixes_inside == 0,
                "none once it is noticed",
            ),
            CaseRow(
                "worst error on the loop, m",
                None,
                round(worst_m, 2),
                worst_m <= RIGHT_M,
                "within 2 m: no wrong fix before it is noticed",
            ),
            CaseRow(
                "right again after the station",
                "once the loop is out of the run's data (600 m)",
                {
                    "behind the last points_m": round(again_m, 1),
                    "worst after_m": round(last_m, 2),
                    "fixes again": again,
                },
                again_m < AFTER_M - 1500.0 and again,
                "fixes are taken again, and the error is within 2 m, within 2 km",
            ),
            CaseRow(
                "the same train on the main track",
                "no mismatch",
                {"told": len(straight.noticed)},
                not straight.noticed,
                "nothing is noticed",
            ),
            bounds_row([self.ride, straight.ride]),
        )


def legs_of(line: Line, place_m: float) -> tuple[float, float]:
    """Where the loop of the station at `place_m` leaves the main track and meets it again, kilometrages (m)."""
    legs = [line.pieces[points.reverse_piece] for points in line.points.values()]
    near = [leg for leg in legs if abs(leg.from_m - place_m) < AROUND_M]
    return min(leg.from_m for leg in near), max(leg.to_m for leg in near)


def slowed_line(place: MountainLine, station: int) -> MountainLine:
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


def run_loop(seed: int, settings: Curvature | None = None, *, sent: bool = True) -> Loop:
    """The run over the loop of the third station; with `sent` off it stays on the main track."""
    curvature = settings or Curvature()
    here = slowed_line(mountain_line(stations=STATIONS), AT)
    from_m, to_m = legs_of(here.line, here.places_m[AT])
    watched = Watch(from_m - BEFORE_M, to_m + AFTER_M, curvature.mismatch_per_m)
    over = (here.station_ids[AT],) if sent else ()
    trip = PlannedTrip(
        here, seed=seed, curvature=curvature, timetable=here.timetable(over), unit_timetable=here.timetable()
    )
    return Loop(trip.run(watched.moments()), watched, from_m, to_m)


def without_threshold(seed: int, straight: Loop) -> tuple[CaseRow, ...]:
    """The null method: whatever map and run differ by, it is the main track."""
    settings = Curvature().model_copy(update={"mismatch_per_m": NO_THRESHOLD_PER_M})
    return run_loop(seed, settings).rows(straight)


def experiment(options: Options) -> Findings:
    """Both runs, and figure 4."""
    loop, straight = run_loop(options.seed), run_loop(options.seed, sent=False)
    without = without_threshold(options.seed, straight)
    chart = loop.watched.chart(
        "harada_loop_track",
        "A train on the loop, by a map of the main track",
        (loop.from_m, loop.to_m, "on the loop"),
    )
    return Findings(
        [replace(row, beside=other.ours) for row, other in zip(loop.rows(straight), without, strict=True)],
        (
            Parameter("station", loop.ride.trip.place.station_ids[AT], "", "any with curves around it"),
            Parameter("speed through it", SLOW_KMH, "km/h", "of diverging legs; the driver sees the signals"),
            Parameter(
                "mismatch that counts", Curvature().mismatch_per_m, "1/m (root mean square)", "[curvature]"
            ),
            *SHARED,
        ),
        [
            "The path of the unit, and so its map, has the main track; the loop is as long, 4 m beside it.",
            "The error says nothing of the threshold: a fix here is an interval that grows with what map and run differ"
            " by, so those that are taken without it move nothing either. What equation 3 does is that the loop is"
            " noticed (without a threshold nothing could be) and that no fix is taken there.",
        ],
        null=without,
        draw=chart.write,
    )


reproduce: Final = Specification(
    "harada-loop-track",
    "A foreign track is noticed by the mismatch of curvature (Harada and others, 3.5, figure 4)",
    experiment,
    NullMethod(
        "no threshold on the mismatch (equation 3)",
        (FIXES,),
        lambda options: without_threshold(options.seed, run_loop(options.seed, sent=False)),
    ),
    LINE,
    beside="no threshold",
)
