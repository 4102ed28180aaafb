"""`branchline reproduce harada-beacons`: the misread beacon of figure 1, and the train that goes by curvature instead.

Harada, Maki, Kazato and Ishiguri, 2.2 and 2.3: on slipping wheels the way is counted too long, beacon X before B lies
in the window of B and is taken for it, C and the next one lie outside their windows, and after two windows without a
beacon the localisation has failed. The same run with the same slip by the collation of curvature, and by beacons that
may not break the bounds (`[beacons] trust`). The matching is the one of line runs (`onboard.localisation.beacons`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from onboard import notes
from simulation.sensor_settings import Beacons, BeaconTrust
from simulation.settings import Carried
from simulation.world.trains import Trains
from study.papers.harada_bench import Ride, Trip, turning, worst_m
from study.papers.harada_chart import write_beacons
from study.papers.mountain_line import ASSUMED, FIGURE_1_M, X_BEFORE_B_M, MountainLine, mountain_line
from study.papers.parameter_sets import LINE
from study.papers.position_run import Moment
from study.papers.reproduction import NullMethod, Options, Parameter, Reproduction, Row

STATIONS: Final = 3
RAIL: Final = 0.12  # of the dry rail's adhesion, from behind A on
SLIPPERY_M: Final = 160.0
AFTER_A_M: Final = 10.0
BESIDE_M: Final = 15.0
WITHIN_M: Final = 2.0
BY_CURVATURE: Final = "by curvature, on the same run"
NULL: Final = NullMethod("beacons without ids, as in section 2", (BY_CURVATURE,))
NAMES: Final = tuple(FIGURE_1_M)


@dataclass(frozen=True, slots=True)
class Method:
    """A run by one method."""

    words: str
    ride: Ride

    def error_at_m(self, name: str) -> float:
        """Estimate less truth where the front passes a beacon of figure 1, after what was made of it, m."""
        at_m = self.ride.trip.place.places_m[0] + FIGURE_1_M[name]
        return next(
            point.error_m
            for point in self.ride.check_points
            if abs(point.true_m - self.ride.base_m - at_m) < 5.0
        )

    @property
    def failed_at_m(self) -> float | None:
        """Where its localisation failed (kilometrage, m)."""
        missed = [
            at_m
            for at_m, note in self.ride.noted(notes.FixMissed)
            if getattr(note, "reader", "") == "beacons"
        ]
        return missed[0] if missed else None

    @property
    def told(self) -> dict[str, object]:
        """What a row says."""
        errors = {f"error at {name}_m": round(self.error_at_m(name), 2) for name in NAMES}
        failed_m = self.failed_at_m
        return {**errors, "failed at_m": None if failed_m is None else round(failed_m)}


def slippery(place: MountainLine) -> list[Moment]:
    """A greasy stretch behind A, while the train gathers speed."""
    from_m = place.places_m[0] + FIGURE_1_M["A"] + AFTER_A_M

    def rail(share: float) -> Moment:
        def so(trains: Trains, slot: int) -> None:
            trains.set_rail(slot, share)

        return Moment(from_m if share < 1.0 else from_m + SLIPPERY_M, so)

    return [rail(RAIL), rail(1.0)]


def over_m(ride: Ride) -> float:
    """By how much the wheels counted the way too long in the run, m."""
    plant = ride.run.trains.plants[0]
    return float(plant.wheel_travelled_m - plant.travelled_m)


def run_method(
    words: str, carries: tuple[Carried, ...], trust: BeaconTrust, seed: int, *, slips: bool = True
) -> Method:
    """The run by one method; without the slip if told."""
    place = mountain_line(stations=STATIONS)
    trip = Trip(place, carries=carries, seed=seed, beacons=Beacons(trust=trust))
    return Method(words, trip.run(slippery(place) if slips else ()))


def rows_of(paper: Method, dry: Method, bounded: Method, curve: Method) -> tuple[Row, ...]:
    """Figure 1, beside ours."""
    beyond = curve.ride.kilometrage_m > curve.ride.trip.place.places_m[0] + FIGURE_1_M["D"]
    after_m = np.asarray(curve.ride.result.trace["estimate_error_m"][beyond], dtype=np.float64)
    misread = abs(paper.error_at_m("X") - X_BEFORE_B_M) <= BESIDE_M
    return (
        Row(
            "by beacons, wheels that roll",
            "every beacon is found (figure 1 (1), (2))",
            dry.told,
            dry.failed_at_m is None and max(abs(dry.error_at_m(name)) for name in NAMES) <= WITHIN_M,
            "within 2 m at each, and no failure",
        ),
        Row(
            "by beacons, X is taken for B",
            f"error: as X lies before B, here {X_BEFORE_B_M:g} m",
            round(paper.error_at_m("X"), 2),
            misread,
            f"within {BESIDE_M:g} m of it",
        ),
        Row(
            "by beacons, C and the next one are missed",
            "localisation has failed after two windows in a row (2.3)",
            paper.told,
            paper.failed_at_m is not None and misread,
            "told in the journal",
        ),
        Row(
            "by beacons that may not break the bounds",
            None,
            {**bounded.told, "out of bounds_m": round(bounded.ride.result.out_m, 3)},
            bounded.ride.result.out_m <= 0.0 < paper.ride.result.out_m,
            "the paper's method puts the truth out of its bounds, this one never",
        ),
        Row(
            BY_CURVATURE,
            "is not misled",
            {
                "wheels counted too long_m": round(over_m(curve.ride), 1),
                "worst after D_m": round(worst_m(after_m), 2),
                "error at X_m": round(curve.error_at_m("X"), 2),
                "out of bounds_m": round(curve.ride.result.out_m, 3),
            },
            curve.failed_at_m is None
            and worst_m(after_m) < X_BEFORE_B_M / 2.0
            and curve.ride.result.out_m <= 0.0,
            "it arrives, never half as wrong after D, and never out of its bounds",
        ),
    )


def reproduce(options: Options) -> Reproduction:
    """The four runs; draws the errors below `options.out`."""
    seed, beacons = options.seed, (Carried.BEACONS,)
    paper = run_method("beacons, as in the paper", beacons, BeaconTrust.PAPER, seed)
    dry = run_method("beacons, dry rail", beacons, BeaconTrust.PAPER, seed, slips=False)
    bounded = run_method("beacons within bounds", beacons, BeaconTrust.BOUNDED, seed)
    curve = run_method("curvature", (Carried.CURVATURE,), BeaconTrust.BOUNDED, seed)
    remarks = [
        "Each is a run of its own on the same line, with the same train, seed and slippery rail.",
        "Bounds that beacons without numbers may not cut only grow: such a train does not come to its last mark.",
    ]
    if options.out is not None:
        shown = [(method.words, method.ride) for method in (paper, curve, bounded)]
        drawn = write_beacons(shown, 3000.0, Path(options.out))
        remarks.append("drawn: " + ", ".join(path.name for path in drawn))
    return Reproduction(
        "harada-beacons",
        "A beacon taken for another, and localisation lost (Harada and others, section 2, figure 1)",
        (
            Parameter("intervals", "440, 600, 520", "m", "table 1: A to B, B to C; C to the next assumed"),
            Parameter(
                "windows", "40, 60, 50", "m", "table 1: 40 of 440, 60 of 600; the last by the same rule"
            ),
            Parameter(
                "X before B",
                X_BEFORE_B_M,
                "m",
                "assumed: figure 1 has no figure; farther than C's window is wide",
            ),
            Parameter(
                "adhesion", RAIL, "of a dry rail", "assumed: greasy leaves while the train gathers speed"
            ),
            Parameter("for", SLIPPERY_M, "m", "chosen so that the wheels count some 50 m too much"),
            *ASSUMED,
            *turning(),
            *LINE.parameters(),
        ),
        (*rows_of(paper, dry, bounded, curve), *NULL.rows(rows_of(paper, dry, bounded, paper))),
        tuple(remarks),
        null=NULL,
    )
