"""`branchline reproduce harada-slide`: wheels lock for seconds, and the next curve tells where the train is.

Harada, Maki, Kazato and Ishiguri, section 4 and figure 6: the wheels of a train lock at 4.45 km, the way that they
count is 127 m short; the track counts as foreign for a while, nothing is corrected, and in the curve at 5.25 km the
position is right again. Ours: the driver applies the emergency brake towards the end of a curve where the rail is damp,
on a train whose slide protection is out of order, and lets go 175 m on. What locks the wheels, and for how long, is
the kernel's physics.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

from onboard import notes
from onboard.localisation.fix import FOREIGN, TAKEN
from onboard.records import EMERGENCY_INTERVENTION, NO_INTERVENTION
from simulation.sensor_settings import Curvature
from simulation.settings import Carried
from simulation.world.trains import Trains
from study.papers.harada_bench import WHEELS, Ride, Trip, turning
from study.papers.harada_chart import write_watched
from study.papers.harada_watch import Watch
from study.papers.mountain_line import ASSUMED, MountainLine, mountain_line
from study.papers.parameter_sets import LINE
from study.papers.position_run import Moment
from study.papers.reproduction import Figure, NullMethod, Options, Parameter, Reproduction, Row

STATIONS: Final = 3
PAPER_SLIDE_M: Final = 127.0
SLIDE_SPREAD_M: Final = 15.0
RAIL: Final = 0.42  # of the dry rail's adhesion
BRAKED_M: Final = 175.0
BEFORE_END_M: Final = 150.0
BEYOND_M: Final = 3000.0
STRAIGHT_LEAST_M: Final = (
    600.0  # N_r: what the slide deforms has left the run's data before the next curve, as in figure 6
)
BACK_WITHIN_M: Final = 2.0
BOUND_MAX_M: Final = 300.0
NULL: Final = NullMethod("wheels alone", ("the next curve brings the error below 2 m",))
FALSE_M: Final = 2.0  # a fix that moves the estimate further off the truth than this is a false one


@dataclass(frozen=True, slots=True)
class Slide:
    """A slide as it came out; kilometrages in m."""

    ride: Ride
    watched: Watch
    from_m: float  # the brake is applied
    to_m: float  # and let go
    curve_from_m: float  # the next curve
    curve_to_m: float

    @property
    def slid_m(self) -> float:
        """By how much the way that the wheels counted was short of the train's."""
        rows = self.watched.between(self.from_m - 20.0, self.curve_from_m)
        return float(rows["slid_m"][-1] - rows["slid_m"][0])

    @property
    def declared(self) -> list[float]:
        """Where the track counted as foreign, from the brake to the curve's end (m)."""
        return [
            at_m for at_m, _ in self.ride.noted(notes.ForeignTrack) if self.from_m <= at_m <= self.curve_to_m
        ]

    @property
    def foreign_rows(self) -> int:
        """Looks at which it did, in the same stretch."""
        return int((self.watched.between(self.from_m, self.curve_to_m)["outcome"] == FOREIGN).sum())

    @property
    def false_fixes(self) -> int:
        """Fixes, until the next curve, that moved the estimate by more than the wheels had, and away from the truth."""
        rows = self.watched.between(self.from_m, self.curve_from_m)
        return sum(
            bool(after["outcome"] == TAKEN and abs(moved_m(before, after)) > FALSE_M and worse(before, after))
            for before, after in pairwise(rows)
        )

    @property
    def back_at_m(self) -> float:
        """From where on the estimate stays within 2 m (m); infinite if it does not."""
        rows = self.watched.between(self.to_m, self.watched.to_m)
        off = abs(rows["error_m"]) > BACK_WITHIN_M
        if not off.any():
            return float(rows["true_m"][0])
        last = int(off.nonzero()[0][-1])
        return float(rows["true_m"][last + 1]) if last + 1 < rows.size else float("inf")


def moved_m(before: object, after: object) -> float:
    """By how much the estimate has moved between two looks, beyond what slid; rows of ROWS."""
    a, b = before, after
    return float((b["error_m"] - a["error_m"]) + (b["slid_m"] - a["slid_m"]))  # type: ignore[index]


def worse(before: object, after: object) -> bool:
    """Whether the estimate is further off the truth than before, by more than what slid."""
    a, b = before, after
    slid_m = b["slid_m"] - a["slid_m"]  # type: ignore[index]
    return bool(abs(b["error_m"]) > abs(a["error_m"]) + abs(slid_m) + FALSE_M)  # type: ignore[index]


def place_of(place: MountainLine) -> tuple[float, float, float]:
    """Where the brake is applied, in the first curve that a straight follows; and where the curve after that is."""
    curves = place.alignment.curves
    for before, after in pairwise(curves):
        if before.from_m > BEYOND_M and after.from_m - before.to_m >= STRAIGHT_LEAST_M:
            return before.to_m - BEFORE_END_M, after.from_m, after.to_m
    raise ValueError("no straight that is long enough")


def braked(from_m: float) -> list[Moment]:
    """The driver brakes on a damp rail, and lets go."""

    def applies(trains: Trains, slot: int) -> None:
        trains.set_rail(slot, RAIL)
        trains.units[slot].intervention = EMERGENCY_INTERVENTION

    def lets_go(trains: Trains, slot: int) -> None:
        trains.set_rail(slot, 1.0)
        trains.units[slot].intervention = NO_INTERVENTION

    return [Moment(from_m, applies), Moment(from_m + BRAKED_M, lets_go)]


def run_slide(
    place: MountainLine,
    seed: int,
    settings: Curvature | None = None,
    carries: tuple[Carried, ...] = (Carried.CURVATURE,),
) -> Slide:
    """The run with the slide, by what the train carries."""
    curvature = settings or Curvature()
    from_m, curve_from_m, curve_to_m = place_of(place)
    unit = WHEELS.model_copy(update={"doubt_bound_max_m": BOUND_MAX_M})
    watched = Watch(from_m - 400.0, curve_to_m + 600.0, curvature.mismatch_per_m)
    trip = Trip(place, carries, seed=seed, curvature=curvature, unit=unit, locks=True)
    ride = trip.run([*braked(from_m), *watched.moments()])
    return Slide(ride, watched, from_m, from_m + BRAKED_M, curve_from_m, curve_to_m)


def rows_of(slide: Slide) -> tuple[Row, ...]:
    """What figure 6 shows, beside ours."""
    ride = slide.ride
    back_at_m = slide.back_at_m
    before = abs(slide.watched.between(slide.to_m, slide.curve_from_m)["error_m"])
    after = abs(slide.watched.between(slide.curve_to_m, slide.watched.to_m)["error_m"])
    return (
        Row(
            "error that the slide leaves, m",
            PAPER_SLIDE_M,
            round(slide.slid_m, 1),
            abs(slide.slid_m - PAPER_SLIDE_M) <= SLIDE_SPREAD_M,
            f"within {SLIDE_SPREAD_M:g} m: no finding, the rail's adhesion is chosen for its {PAPER_SLIDE_M:g} m",
        ),
        Row(
            "the track counts as foreign",
            "while the wheels' slide is in the run's data",
            {"told at_m": [round(at_m) for at_m in slide.declared], "looks of 10 m": slide.foreign_rows},
            bool(slide.declared) or slide.foreign_rows > 0,
            "declared in the journal",
        ),
        Row(
            "false fixes before the next curve",
            0,
            {"count": slide.false_fixes, "error there_m": round(float(before.max()), 1)},
            slide.false_fixes == 0,
            f"no fix moves the estimate by more than {FALSE_M:g} m away from the truth",
        ),
        Row(
            "the next curve brings the error below 2 m",
            f"curve {slide.curve_from_m - slide.to_m + BRAKED_M:.0f} m on (800 m in the paper)",
            {
                "from_m": round(back_at_m - slide.curve_from_m, 1),
                "worst after it_m": round(float(after.max()), 2),
            },
            back_at_m <= slide.curve_to_m,
            "and it stays so, from within the curve on",
        ),
        Row(
            "truth out of the stated bounds",
            None,
            round(ride.result.out_m, 3),
            ride.result.out_m <= 0.0,
            "never, in any step",
        ),
    )


def parameters(slide: Slide) -> tuple[Parameter, ...]:
    """What was chosen, and why."""
    return (
        Parameter(
            "brake applied at",
            round(slide.from_m),
            "m",
            f"{BEFORE_END_M:g} m before the end of a curve that a straight follows",
        ),
        Parameter("and let go after", BRAKED_M, "m", "assumed: the paper's train goes on after its slide"),
        Parameter(
            "adhesion", RAIL, "of a dry rail", "chosen so that the slide is about as long as the paper's"
        ),
        Parameter("slide protection", "none", "", "assumed: out of order; figure 6 shows locked wheels"),
        Parameter(
            "bounds at which a train that seems to stand goes on sight",
            BOUND_MAX_M,
            "m",
            "assumed for this run: the paper's equipment tells where a train is and does not stop it",
        ),
        *ASSUMED,
        *turning(),
        *LINE.parameters(),
    )


def reproduce(options: Options) -> Reproduction:
    """The run; draws figure 6 below `options.out`."""
    place = mountain_line(stations=STATIONS)
    slide = run_slide(place, options.seed)
    wheels = run_slide(place, options.seed, carries=())
    remarks = [
        "The unit goes on by its wheels while it takes no fix, and its bounds grow by what a slide may hide."
    ]
    if options.out is not None:
        drawn = drawn_slide(slide, Path(options.out))
        remarks.append("drawn: " + ", ".join(path.name for path in drawn))
    outside: Sequence[Figure] = (
        Figure(
            "worst bounds, m", round(float(slide.watched.rows["ahead_m"].max()), 1), "ahead, after the slide"
        ),
    )
    return Reproduction(
        "harada-slide",
        "A slide of the wheels, and the curve after it (Harada and others, section 4, figure 6)",
        parameters(slide),
        (*rows_of(slide), *NULL.rows(rows_of(wheels))),
        tuple(remarks),
        tuple(outside),
        null=NULL,
    )


def drawn_slide(slide: Slide, folder: Path) -> tuple[Path, ...]:
    """Figure 6."""
    marks = (
        (slide.from_m, slide.to_m, "braked on a damp rail"),
        (slide.curve_from_m, slide.curve_to_m, "next curve"),
    )
    return write_watched(
        slide.watched, marks, f"Wheels lock and count {slide.slid_m:.0f} m short", folder, "harada_slide"
    )
