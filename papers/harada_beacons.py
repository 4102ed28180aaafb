"""`branchline reproduce harada-beacons`: the misread beacon of figure 1, and the train that goes by curvature instead.

Harada, Maki, Kazato and Ishiguri, 2.2 and 2.3: on slipping wheels the way is counted too long, beacon X before B lies
in the window of B and is taken for it, C and the next one lie outside their windows, and after two windows without a
beacon the localisation has failed. The same run with the same slip by the collation of curvature, and by beacons that
may not break the bounds (`[beacons] trust`). The matching is the one of line runs (`onboard.localisation.beacons`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from onboard import notes
from papers.charts import BLUE, ChartPage, Panel, Plotted, Ruled, Shaded
from papers.harada_bench import SHARED, PlannedTrip, TripRun, worst_m
from papers.mountain_line import FIGURE_1_M, X_BEFORE_B_M, MountainLine, mountain_line
from papers.parameter_sets import LINE
from papers.position_run import Moment, slippery
from papers.reproduction import CaseRow, NullMethod, Options, Parameter
from papers.specification import Findings, Specification
from simulation.sensor_settings import Beacons, BeaconTrust
from simulation.settings import PositionSensor
from study.report.style import INK, RED

STATIONS: Final = 3
RAIL: Final = 0.12  # of the dry rail's adhesion, from behind A on
SLIPPERY_M: Final = 160.0
AFTER_A_M: Final = 10.0
BESIDE_M: Final = 15.0
WITHIN_M: Final = 2.0
BY_CURVATURE: Final = "by curvature, on the same run"
NAMES: Final = tuple(FIGURE_1_M)
USED: Final = tuple(name for name in NAMES if name != "X")  # by the database


@dataclass(frozen=True, slots=True)
class Method:
    """A run by one method."""

    words: str
    ride: TripRun

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
            for at_m, note in self.ride.notes_of(notes.FixMissed)
            if getattr(note, "reader", "") == "beacons"
        ]
        return missed[0] if missed else None

    @property
    def figures(self) -> dict[str, object]:
        """What a row says."""
        errors = {f"error at {name}_m": round(self.error_at_m(name), 2) for name in NAMES}
        failed_m = self.failed_at_m
        return {**errors, "failed at_m": None if failed_m is None else round(failed_m)}


def slip(place: MountainLine) -> list[Moment]:
    """A greasy stretch behind A, while the train gathers speed."""
    from_m = place.places_m[0] + FIGURE_1_M["A"] + AFTER_A_M
    return slippery(from_m, from_m + SLIPPERY_M, RAIL)


def run_method(
    words: str, carries: tuple[PositionSensor, ...], trust: BeaconTrust, seed: int, *, slips: bool = True
) -> Method:
    """The run by one method, with the slip or without."""
    place = mountain_line(stations=STATIONS)
    trip = PlannedTrip(place, carries=carries, seed=seed, beacons=Beacons(trust=trust))
    return Method(words, trip.run(slip(place) if slips else ()))


def beacon_rows(paper: Method, dry: Method, bounded: Method) -> tuple[CaseRow, ...]:
    """Figure 1, beside ours."""
    misread = abs(paper.error_at_m("X") - X_BEFORE_B_M) <= BESIDE_M
    return (
        CaseRow(
            "by beacons, wheels that roll",
            "every beacon is found (figure 1 (1), (2))",
            dry.figures,
            dry.failed_at_m is None and max(abs(dry.error_at_m(name)) for name in USED) <= WITHIN_M,
            "within 2 m at each that the database has, and no failure",
        ),
        CaseRow(
            "by beacons, X is taken for B",
            f"error: as X lies before B, here {X_BEFORE_B_M:g} m",
            round(paper.error_at_m("X"), 2),
            misread,
            f"within {BESIDE_M:g} m of it",
        ),
        CaseRow(
            "by beacons, C and the next one are missed",
            "localisation has failed after two windows in a row (2.3)",
            paper.figures,
            paper.failed_at_m is not None and misread,
            "told in the journal",
        ),
        CaseRow(
            "by beacons that may not break the bounds",
            None,
            {**bounded.figures, "out of bounds_m": round(bounded.ride.result.out_m, 3)},
            bounded.ride.result.held and paper.ride.result.out_m > 0.0,
            "the paper's method puts the truth out of its bounds, this one never",
        ),
    )


def curvature_row(curve: Method) -> CaseRow:
    """That a train that goes by curvature is not misled, by whatever it goes."""
    ride = curve.ride
    beyond = ride.kilometrage_m > ride.trip.place.places_m[0] + FIGURE_1_M["D"]
    after_m = worst_m(np.asarray(ride.result.trace["estimate_error_m"][beyond], dtype=np.float64))
    plant = ride.run.trains.plants[0]
    return CaseRow(
        BY_CURVATURE,
        "is not misled",
        {
            "wheels counted too long_m": round(float(plant.wheel_travelled_m - plant.travelled_m), 1),
            "worst after D_m": round(after_m, 2),
            "error at X_m": round(curve.error_at_m("X"), 2),
            "out of bounds_m": round(ride.result.out_m, 3),
        },
        ride.result.arrived and after_m < X_BEFORE_B_M / 2.0 and ride.result.held,
        "it arrives, never half as wrong after D, and never out of its bounds",
    )


def chart(methods: Sequence[Method], until_m: float = 3000.0) -> ChartPage:
    """Figure 1 (3): the error over the way by beacons and by curvature, with the beacons and their windows."""
    line = methods[0].ride.trip.place.line
    beacons = [beacon for beacon in line.beacons.values() if beacon.position_m <= until_m]
    windows = [
        Shaded(beacon.position_m - beacon.window_m, beacon.position_m + beacon.window_m)
        for beacon in beacons
        if beacon.used and beacon.window_m
    ]
    errors: list[Plotted] = []
    for method, colour in zip(methods, (BLUE, RED, "#c08a2b"), strict=True):
        at_m = method.ride.kilometrage_m
        error_m = method.ride.result.trace["estimate_error_m"]
        errors.append(
            Plotted(at_m[at_m <= until_m], error_m[at_m <= until_m], method.words, colour, width=1.0)
        )
    panel = Panel(
        "kilometrage, m (lines: beacons, dotted where no database goes by them; grey: windows)",
        "estimate less truth, m",
        [
            *errors,
            Ruled([beacon.position_m for beacon in beacons if beacon.used], colour=INK, style="-"),
            Ruled([beacon.position_m for beacon in beacons if not beacon.used], style=":"),
            *windows,
        ],
        "Wheels slip after the first beacon: another one is taken for the second, and the next two are missed",
    )
    return ChartPage("harada_beacons", (9.0, 4.6), [[panel]])


def by_paper(seed: int) -> Method:
    """The paper's section 2: beacons without numbers, on wheels that slip."""
    return run_method("beacons, as in the paper", (PositionSensor.BEACONS,), BeaconTrust.PAPER, seed)


def experiment(options: Options) -> Findings:
    """The four runs, and figure 1."""
    seed, beacons = options.seed, (PositionSensor.BEACONS,)
    paper = by_paper(seed)
    dry = run_method("beacons, dry rail", beacons, BeaconTrust.PAPER, seed, slips=False)
    bounded = run_method("beacons within bounds", beacons, BeaconTrust.BOUNDED, seed)
    curve = run_method("curvature", (PositionSensor.CURVATURE,), BeaconTrust.BOUNDED, seed)
    return Findings(
        (*beacon_rows(paper, dry, bounded), curvature_row(curve)),
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
            *SHARED,
        ),
        [
            "Each is a run of its own on the same line, with the same train, seed and slippery rail.",
            "Bounds that beacons without numbers may not cut only grow: such a train does not come to its last mark.",
        ],
        null=[curvature_row(paper)],
        draw=chart((paper, curve, bounded)).write,
    )


reproduce: Final = Specification(
    "harada-beacons",
    "A beacon taken for another, and localisation lost (Harada and others, section 2, figure 1)",
    experiment,
    NullMethod(
        "beacons without ids, as in section 2",
        (BY_CURVATURE,),
        lambda options: [curvature_row(by_paper(options.seed))],
    ),
    LINE,
)
