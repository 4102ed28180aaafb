"""`branchline reproduce harada-slide`: wheels lock for seconds, and the next curve tells where the train is.

Harada, Maki, Kazato and Ishiguri, section 4 and figure 6: the wheels of a train lock at 4.45 km, the way that they
count is 127 m short; the track counts as foreign for a while, nothing is corrected, and in the curve at 5.25 km the
position is right again. Ours: the driver applies the emergency brake towards the end of a curve where the rail is damp,
on a train whose slide protection is out of order, and lets go 175 m on. What locks the wheels, and for how long, is
the kernel's physics.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

from onboard.localisation.fix import FOREIGN, TAKEN
from onboard.records import EMERGENCY_INTERVENTION, NO_INTERVENTION
from papers.harada_bench import SHARED, WHEELS, PlannedTrip, TripRun, Watch, bounds_row
from papers.mountain_line import MountainLine, mountain_line
from papers.parameter_sets import LINE
from papers.position_run import Moment
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.specification import REPORTED, Findings, Specification
from simulation.sensor_settings import Curvature
from simulation.settings import PositionSensor
from simulation.world.trains import Trains

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
FALSE_M: Final = 2.0  # a fix that moves the estimate further off the truth than this is a false one
COUNTS: Final = "the track counts as foreign"
NEXT_CURVE: Final = "the next curve brings the error below 2 m"


@dataclass(frozen=True, slots=True)
class Slide:
    """A slide as it came out; kilometrages in m."""

    ride: TripRun
    watched: Watch
    from_m: float  # the brake is applied
    to_m: float  # and let go
    curve_from_m: float  # the next curve
    curve_to_m: float

    @property
    def slid_m(self) -> float:
        """By how much the way that the wheels counted was short of the train's."""
        rows = self.watched.moments_between(self.from_m - 20.0, self.curve_from_m)
        return float(rows["slid_m"][-1] - rows["slid_m"][0])

    @property
    def false_fixes(self) -> int:
        """Fixes, until the next curve, that moved the estimate by more than the wheels had, and away from the truth."""
        rows = self.watched.moments_between(self.from_m, self.curve_from_m)
        return sum(
            bool(after["outcome"] == TAKEN) and is_false(before, after) for before, after in pairwise(rows)
        )

    def rows(self) -> tuple[CaseRow, ...]:
        """What figure 6 shows, beside ours."""
        declared = self.ride.foreign_at_m(self.from_m, self.curve_to_m)  # from the brake to the curve's end
        foreign = int(
            (self.watched.moments_between(self.from_m, self.curve_to_m)["outcome"] == FOREIGN).sum()
        )
        back_at_m = self.watched.within_from_m(self.to_m, BACK_WITHIN_M)
        before_m = self.watched.worst_m(self.to_m, self.curve_from_m)
        after_m = self.watched.worst_m(self.curve_to_m, self.watched.to_m)
        return (
            CaseRow(
                "error that the slide leaves, m",
                PAPER_SLIDE_M,
                round(self.slid_m, 1),
                abs(self.slid_m - PAPER_SLIDE_M) <= SLIDE_SPREAD_M,
                f"within {SLIDE_SPREAD_M:g} m: no finding, the rail's adhesion is chosen for its {PAPER_SLIDE_M:g} m",
            ),
            CaseRow(
                NEXT_CURVE,
                f"curve {self.curve_from_m - self.to_m + BRAKED_M:.0f} m on (800 m in the paper)",
                {"from_m": round(back_at_m - self.curve_from_m, 1), "worst after it_m": round(after_m, 2)},
                back_at_m <= self.curve_to_m,
                "and it stays so, from within the curve on",
            ),
            CaseRow(
                COUNTS,
                "while the wheels' slide is in the run's data",
                {"told at_m": [round(at_m) for at_m in declared], "looks of 10 m": foreign},
                bool(declared) or foreign > 0,
                "declared in the journal",
            ),
            CaseRow(
                "false fixes before the next curve",
                0,
                {"count": self.false_fixes, "error there_m": round(before_m, 1)},
                True,
                f"none moves the estimate by more than {FALSE_M:g} m away from the truth; wheels alone, and curvature"
                f" without a threshold, have none either: {REPORTED}",
                judged=False,
            ),
            bounds_row([self.ride]),
        )


def is_false(before: Any, after: Any) -> bool:  # noqa: ANN401 - rows of a Watch
    """Whether the estimate moved between two looks by more than slid, and further off the truth."""
    slid_m = float(after["slid_m"] - before["slid_m"])
    moved_m = float(after["error_m"] - before["error_m"]) + slid_m
    off_m = float(abs(after["error_m"]) - abs(before["error_m"]))
    return abs(moved_m) > FALSE_M and off_m > abs(slid_m) + FALSE_M


def place_of(place: MountainLine) -> tuple[float, float, float]:
    """Where the brake is applied, in the first curve that a straight follows; and where the curve after that is."""
    curves = place.alignment.curves
    for before, after in pairwise(curves):
        if before.from_m > BEYOND_M and after.from_m - before.to_m >= STRAIGHT_LEAST_M:
            return before.to_m - BEFORE_END_M, after.from_m, after.to_m
    raise ValueError("no straight that is long enough")


def damp_rail_braking(from_m: float) -> list[Moment]:
    """The driver brakes on a damp rail, and lets go."""

    def then(at_m: float, rail: float, intervention: int) -> Moment:
        def act(trains: Trains, slot: int) -> None:
            trains.set_rail(slot, rail)
            trains.units[slot].intervention = intervention

        return Moment(at_m, act)

    return [
        then(from_m, RAIL, EMERGENCY_INTERVENTION),
        then(from_m + BRAKED_M, 1.0, NO_INTERVENTION),
    ]


def run_slide(
    seed: int,
    settings: Curvature | None = None,
    carries: tuple[PositionSensor, ...] = (PositionSensor.CURVATURE,),
) -> Slide:
    """The run with the slide, by what the train carries."""
    place = mountain_line(stations=STATIONS)
    curvature = settings or Curvature()
    from_m, curve_from_m, curve_to_m = place_of(place)
    unit = WHEELS.model_copy(update={"doubt_bound_max_m": BOUND_MAX_M})
    watched = Watch(from_m - 400.0, curve_to_m + 600.0, curvature.mismatch_per_m)
    trip = PlannedTrip(place, carries, seed=seed, curvature=curvature, unit=unit, locks=True)
    ride = trip.run([*damp_rail_braking(from_m), *watched.moments()])
    return Slide(ride, watched, from_m, from_m + BRAKED_M, curve_from_m, curve_to_m)


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
        *SHARED,
    )


def experiment(options: Options) -> Findings:
    """The run, and figure 6."""
    slide = run_slide(options.seed)
    worst_m = round(float(slide.watched.rows["ahead_m"].max()), 1)
    chart = slide.watched.chart(
        "harada_slide",
        f"Wheels lock and count {slide.slid_m:.0f} m short",
        (slide.from_m, slide.to_m, "braked on a damp rail"),
        (slide.curve_from_m, slide.curve_to_m, "next curve"),
    )
    return Findings(
        slide.rows(),
        parameters(slide),
        [
            "The unit goes on by its wheels while it takes no fix, and its bounds grow by what a slide may hide."
        ],
        [UnjudgedFigure("worst bounds, m", worst_m, "ahead, after the slide")],
        draw=chart.write,
    )


reproduce: Final = Specification(
    "harada-slide",
    "A slide of the wheels, and the curve after it (Harada and others, section 4, figure 6)",
    experiment,
    NullMethod(
        "wheels alone", (NEXT_CURVE, COUNTS), lambda options: run_slide(options.seed, carries=()).rows()
    ),
    LINE,
)
