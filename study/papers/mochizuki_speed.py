"""`branchline reproduce mochizuki-speed`: speed by a LiDAR from markers, sections 3, 5.1 and 5.2 of the paper.

Mochizuki, Kudo and Yamaguchi. Four passages with the speeds of tables 1 and 3, each run many times with other phases of
the scan and other noise: how far the train runs until the speed has settled, and by how much it is wrong afterwards.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from onboard.localisation.lidar_points import FARTHEST_M, MEANS
from study.papers.marker_passages import KMH, USES, Floats, Passage, Seen, Use, parameters, pass_markers
from study.papers.mochizuki_charts import write_speed
from study.papers.reproduction import Options, Parameter, Reproduction, Row

RUNS: Final = 200
RUNS_QUICK: Final = 24
SETTLES_WITHIN: Final = 0.25
JUDGED_FROM_M: Final = 20.0  # 5.2; to 5 m
PAPER_KMH: Final = 3.0
AIM_KMH: Final = 2.0
OF_PASSAGES: Final = 0.95  # share that must keep within


@dataclass(frozen=True, slots=True)
class Case:
    """A passage of tables 1 and 3: speeds by GNSS when settled and at the markers, km/h, and the distance, m."""

    name: str
    settled_kmh: float
    markers_kmh: float
    settles_m: float

    @property
    def settled_at_m(self) -> float:
        """How far the markers' middle is then."""
        return FARTHEST_M - self.settles_m

    @property
    def acceleration_mps2(self) -> float:
        """Even from there to the markers (assumed): the two speeds are of one passage."""
        squares = (self.markers_kmh**2 - self.settled_kmh**2) / KMH**2
        return squares / (2.0 * self.settled_at_m)

    def run(self, number: int, seed: int) -> Passage:
        """One passage of it."""
        far_mps, far_m = self.settled_kmh / KMH, self.settled_at_m
        return pass_markers(self.name, number, seed, far_mps, self.acceleration_mps2, far_m=far_m)


CASES: Final = (
    Case("pattern 1, first", 36.2, 36.6, 10.3),
    Case("pattern 1, second", 12.8, 9.6, 3.86),
    Case("pattern 2", 35.0, 36.1, 10.2),
    Case("pattern 3", 25.3, 25.3, 8.12),
)
CONSTANT: Final = Case("constant 9.6 km/h", 9.6, 9.6, 3.86)


def settles_m(seen: Seen) -> float:
    """The way from where detection begins to where the speed gains no more (5.1), m; nan: it never does.

    While the first mean still fills, noise of single cycles may stop the gain: it counts from a mean's length on.
    """
    within = np.flatnonzero(seen.mean_m > 0.0)
    if within.size == 0:
        return float("nan")
    begin = int(within[0])
    gains = np.diff(seen.speed_mps)
    for cycle in range(begin + MEANS, gains.size):
        if gains[cycle] <= 0.0 < seen.mean_m[cycle + 1]:
            return float(seen.mean_m[begin] - seen.mean_m[cycle + 1])
    return float("nan")


def errors_kmh(seen: Seen) -> Floats:
    """By how much the speed is wrong in each cycle between 20 and 5 m."""
    judged = (seen.mean_m > 0.0) & (seen.mean_m <= JUDGED_FROM_M)
    return np.abs(seen.speed_mps - seen.true_mps)[judged] * KMH


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """What came of a case: distances until settled (m), errors of all cycles and the largest of each passage (km/h)."""

    case: Case
    settles_m: Floats
    errors_kmh: Floats
    largest_kmh: Floats
    shown: Seen  # the first passage

    @property
    def middle_m(self) -> float:
        """Median of the distances; nan: none settled."""
        known = self.settles_m[np.isfinite(self.settles_m)]
        return float(np.median(known)) if known.size else float("nan")


def find(case: Case, runs: int, seed: int, use: Use) -> Found:
    """All runs of a case."""
    seen = [case.run(number, seed).seen(use) for number in range(runs)]
    errors = [errors_kmh(each) for each in seen]
    return Found(
        case,
        np.array([settles_m(each) for each in seen]),
        np.concatenate(errors),
        np.array([each.max() if each.size else np.inf for each in errors]),
        seen[0],
    )


def rows_of(found: Found) -> list[Row]:
    """The rows of one case."""
    case, name = found.case, found.case.name
    off = abs(found.middle_m - case.settles_m) / case.settles_m
    low_m, high_m = np.nanquantile(found.settles_m, (0.05, 0.95)) if np.isfinite(off) else (np.nan, np.nan)
    ours: dict[str, object] = {
        "median_m": round(found.middle_m, 2),
        "from_m": round(float(low_m), 2),
        "to_m": round(float(high_m), 2),
        "off_share": round(off, 3),
    }
    rows = [
        Row(
            f"{name}: settles after, m",
            case.settles_m,
            ours,
            bool(off <= SETTLES_WITHIN),
            f"median within {SETTLES_WITHIN:.0%}; 5 % and 95 % beside it",
        )
    ]
    quantiles = np.quantile(found.errors_kmh, (0.5, 0.95, 0.99))
    for limit, whose in ((PAPER_KMH, "as the paper"), (AIM_KMH, "our aim")):
        share = float(np.mean(found.largest_kmh < limit))
        rows.append(
            Row(
                f"{name}: error from 20 to 5 m below {limit:g} km/h",
                limit,
                {
                    "passages_below": round(share, 3),
                    "largest_of_median_passage_kmh": round(float(np.median(found.largest_kmh)), 2),
                    "median_kmh": round(float(quantiles[0]), 2),
                    "of_95_percent_kmh": round(float(quantiles[1]), 2),
                    "of_99_percent_kmh": round(float(quantiles[2]), 2),
                    "largest_kmh": round(float(found.largest_kmh.max()), 2),
                },
                share >= OF_PASSAGES,
                f"the largest error below it in {OF_PASSAGES:.0%} of the passages; {whose}",
            )
        )
    return rows


def cases_of(runs: int, seed: int, use: Use) -> tuple[list[Row], list[Found]]:
    """All rows, for one use of the points, and what they stand on."""
    found = [find(case, runs, seed, use) for case in CASES]
    rows = [row for each in found for row in rows_of(each)]
    constant = find(CONSTANT, runs, seed, use)
    rows.append(
        Row(
            "constant 9.6 km/h (table 1): settles after, m",
            CONSTANT.settles_m,
            round(constant.middle_m, 2),
            True,
            "reported, not judged: 49 cycles at 2.67 m/s are 2.6 m, so the train of table 3 must have been faster",
        )
    )
    return rows, found


def reproduce(options: Options) -> Reproduction:
    """The four passages; `options.out` takes the distributions as a figure."""
    runs = RUNS_QUICK if options.quick else RUNS
    rows, found = cases_of(runs, options.seed, USES["as the paper"])
    remarks = [
        "Table 1 says 9.6 km/h and table 3 12.8 for one passage: the tram slows, by "
        f"{-CASES[1].acceleration_mps2:.3f} m/s2 if it does so evenly from where the speed has settled to the markers; "
        f"pattern 2 gains {CASES[2].acceleration_mps2:.3f} m/s2. Both decelerations are assumed so.",
        "The paper has one passage of each; ours are distributions over phases of the scan and noise.",
        "Where no point hits a marker for a tenth of a second, equation 3 gives 0 and the way is lost: the rare "
        "passages with errors of several km/h.",
    ]
    if options.quick:
        remarks.append(f"Quick: {runs} passages a case instead of {RUNS}.")
    if options.out is not None:
        written = write_speed(found, Path(options.out))
        remarks.append(f"Wrote {', '.join(path.name for path in written)}.")
    runs_used = Parameter("passages a case", runs, "", "assumed: enough for shares of a hundredth")
    return Reproduction(
        "mochizuki-speed",
        "Speed by a LiDAR from markers between the rails (Mochizuki, Kudo, Yamaguchi, 3, 5.1, 5.2)",
        (*parameters(), runs_used),
        tuple(rows),
        tuple(remarks),
    )
