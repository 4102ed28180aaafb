"""`branchline reproduce ttobench`: least time and least energy on the tracks and trains of TTOBench, each with a proof.

Every train runs every track from its first stop to its last, past those between, as the library's authors do; in the
least time, and with least energy in 1.05, 1.1 and 1.2 times that, without losses ("perfect") and with the constant
efficiencies of the files ("static"). Beside the energy of a run that is possible to the metre, found on the mesh of a
unit, stands the bound that none can go below (`vehicle.optimum.bound`), looked for on a finer one. The authors' own
figures are those of a local optimum, without one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from network.units import J_PER_KWH
from papers.parameter_sets import NotDriven
from papers.reference_data import reference_folder
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.specification import Findings, Specification
from papers.ttobench_files import BenchTrain, TtobenchTrack, course_of, read_tracks, read_trains
from vehicle.optimum import Course, least_time
from vehicle.optimum.coast import cruise_run
from vehicle.optimum.proof import ProvenRun, proven_run

FOLDER: Final = "ttobench"
TIMES: Final = (1.05, 1.1, 1.2)
POINTS: Final = 300  # as aboard: the mesh whose solution is timed (`study.evaluate.optimum_bench`)
BOUND_POINTS: Final = 900
GAP: Final = 0.01
OFF: Final = 0.01
QUICK: Final = (
    ("CH_Fribourg_Bern", "CH_Stadler_FLIRT_TPF"),
    ("CN_Songjiazhuang_Yizhuang", "CN_Beijing_Subway"),
    ("00_reference_with_tunnels", "CH_Stadler_FLIRT_TPF"),
)
HELD: Final = ("CH_Fribourg_Bern", "CH_Stadler_FLIRT_TPF", "static")
EFFICIENCIES: Final = (("perfect", True), ("static", False))


@dataclass(frozen=True, slots=True)
class CrossCheck:
    """Runs of the authors' own problem: 1 m/s at both ends, the electric brake alone, on a mesh and a coarser one."""

    track: str
    time_s: float
    perfect: bool
    energy_kwh: float  # on FINE intervals
    coarse_kwh: float  # on COARSE


CROSS_TRAIN: Final = "NL_Intercity_VIRM6"
CROSS_END_MPS: Final = 1.0
COARSE: Final = 300
FINE: Final = 1000  # a tolerance of 1 % needs a mesh whose own error is far below it
CROSS_CHECKS: Final = (
    CrossCheck("00_var_speed_limit_100", 1541.0, True, 306.29, 307.55),
    CrossCheck("00_var_speed_limit_100", 1541.0, False, 372.71, 374.68),
    CrossCheck("CH_Fribourg_Bern", 1400.0, True, 30.82, 31.25),
    CrossCheck("CH_Fribourg_Bern", 1400.0, False, 60.51, 61.36),
)
LOSSY: Final = tuple(check for check in CROSS_CHECKS if not check.perfect)
SIMPLER_TRACK, SIMPLER_TRAIN = "CH_Fribourg_Bern", "CH_Stadler_FLIRT_TPF"
SIMPLER_LEAST_S, SIMPLER_TIMES, SIMPLER_KWH = 1103.0, 1.1, 91.0


@dataclass(frozen=True, slots=True)
class MeshPair:
    """One instance in one time on both meshes, each with the bound that is found on it."""

    coarse: ProvenRun
    fine: ProvenRun

    @property
    def judged(self) -> ProvenRun:
        """The run of the coarse mesh, and the better of the two bounds: either holds for every run."""
        return replace(self.coarse, bound_j=max(self.coarse.bound_j, self.fine.bound_j))


def pair_of(course: Course, time_s: float) -> MeshPair:
    """An instance on both meshes."""
    return MeshPair(proven_run(course, time_s, POINTS), proven_run(course, time_s, BOUND_POINTS))


def _figures(pairs: list[MeshPair]) -> tuple[UnjudgedFigure, ...]:
    """Gaps as they are judged, and with one mesh for the run and its bound."""

    def greatest(name: str, gaps: list[float], meaning: str) -> UnjudgedFigure:
        within = sum(gap <= GAP for gap in gaps)
        text = f"{meaning}; {within} of {len(gaps)} are within {100.0 * GAP:g} %"
        return UnjudgedFigure(f"greatest gap, {name}, %", round(100.0 * max(gaps), 3), text)

    return (
        greatest(
            f"run of {POINTS} points",
            [pair.judged.gap for pair in pairs],
            f"as the rows are judged: the bound is looked for with {BOUND_POINTS} points",
        ),
        greatest(
            f"run and bound of {POINTS} points",
            [pair.coarse.gap for pair in pairs],
            "most of it is the bound's: costates are straight on each stretch",
        ),
        greatest(
            f"run and bound of {BOUND_POINTS} points", [pair.fine.gap for pair in pairs], "a finer run too"
        ),
    )


def _pairs(
    tracks: Mapping[str, TtobenchTrack], trains: Mapping[str, BenchTrain], *, quick: bool
) -> Iterator[tuple[TtobenchTrack, BenchTrain]]:
    if quick:
        yield from ((tracks[track], trains[train]) for track, train in QUICK)
    else:
        yield from ((track, train) for track in tracks.values() for train in trains.values())


def row_of(case: str, least_s: float, pairs: list[MeshPair]) -> CaseRow:
    """One instance at its three running times; the run that is judged is that of a unit's mesh."""
    ours: dict[str, object] = {"least_s": round(least_s, 2)}
    for share, pair in zip(TIMES, pairs, strict=True):
        proof = pair.judged
        ours[f"{share:g}"] = {
            "time_s": round(proof.time_s, 2),
            "energy_kwh": round(proof.energy_j / J_PER_KWH, 3),
            "bound_kwh": round(proof.bound_j / J_PER_KWH, 3),
            "gap_percent": round(100.0 * proof.gap, 3),
            f"gap_of_{POINTS}_alone_percent": round(100.0 * pair.coarse.gap, 3),
            f"gap_of_{BOUND_POINTS}_percent": round(100.0 * pair.fine.gap, 3),
        }
    held = all(-1e-9 <= pair.judged.gap <= GAP for pair in pairs)
    criterion = f"gap at most {100.0 * GAP:g} % for the run of {POINTS} points, bound with {BOUND_POINTS}"
    return CaseRow(case, None, ours, held, criterion)


def cruising_row(track: TtobenchTrack, train: BenchTrain) -> CaseRow:
    """The instance of the null method: as fast as it can up to the speed that it then holds."""
    course = course_of(track, train, perfect=False)
    least_s = float(least_time(course).time_s[-1])
    pairs: list[MeshPair] = []
    for share in TIMES:
        pair = pair_of(course, share * least_s)
        run = cruise_run(course, share * least_s)
        pairs.append(replace(pair, coarse=replace(pair.coarse, energy_j=run.energy_j)))
    return row_of(", ".join(HELD), least_s, pairs)


def cross_case(check: CrossCheck) -> str:
    """What the row of a cross-check is called."""
    word = "perfect" if check.perfect else "static"
    return (
        f"cross-check: {check.track}, {CROSS_TRAIN}, {word}, {check.time_s:g} s, {FINE} intervals each, kWh"
    )


def cross_row(
    track: TtobenchTrack, train: BenchTrain, check: CrossCheck, *, cruising: bool = False
) -> CaseRow:
    """The authors' figure beside ours, of the same problem. A bound above a run that was made would be wrong.

    `cruising`: by the null method in place of the optimum.
    """
    course = course_of(track, train, perfect=check.perfect, end_mps=CROSS_END_MPS, friction=False)
    proof = proven_run(course, check.time_s, FINE + 1)
    energy_j = cruise_run(course, check.time_s).energy_j if cruising else proof.energy_j
    ours_kwh = energy_j / J_PER_KWH
    off = ours_kwh / check.energy_kwh - 1.0
    bound_kwh = proof.bound_j / J_PER_KWH
    ours = {
        "energy_kwh": round(ours_kwh, 2),
        "bound_kwh": round(bound_kwh, 2),
        "off_percent": round(100.0 * off, 2),
        "theirs_would_take_s": round(_time_for_s(course, proof, check.energy_kwh * J_PER_KWH), 1),
        f"theirs_on_{COARSE}_kwh": check.coarse_kwh,
    }
    short = abs(off) - OFF
    criterion = f"within {100.0 * OFF:g} %, and our bound not above theirs"
    if check.perfect:
        criterion += "; without losses one cruising speed meets it too, which shows nothing"
    if short > 0.0:
        criterion += f"; missed by {100.0 * short:.2f} points: ours is {'less' if off < 0.0 else 'more'}"
    held = short <= 0.0 and bound_kwh <= check.energy_kwh
    return CaseRow(cross_case(check), check.energy_kwh, ours, held, criterion)


def _time_for_s(course: Course, proof: ProvenRun, energy_j: float) -> float:
    """The running time for which our optimum needs an energy, s; along the price of a second, in a few steps."""
    time_s = proof.time_s
    for _ in range(4):
        found = proven_run(course, time_s, FINE + 1)
        time_s += (found.energy_j - energy_j) / found.optimum.price_w
    return time_s


def _simpler_rows(track: TtobenchTrack, train: BenchTrain) -> tuple[CaseRow, CaseRow]:
    """A published pair of figures by a simpler model."""
    course = course_of(track, train, perfect=False)
    least_s = float(least_time(course).time_s[-1])
    proof = proven_run(course, SIMPLER_TIMES * least_s, FINE + 1)
    kwh, bound_kwh = proof.energy_j / J_PER_KWH, proof.bound_j / J_PER_KWH
    case = f"{track.id}, {train.id}, by a simpler model"
    criterion = f"within {100.0 * OFF:g} %"
    short = abs(kwh / SIMPLER_KWH - 1.0) - OFF
    of_energy = criterion
    if short > 0.0:
        of_energy += f"; missed by {100.0 * short:.2f} points"
    if bound_kwh > SIMPLER_KWH:
        of_energy += f": theirs is below our bound, {bound_kwh:.2f}, so theirs is another problem"
    return (
        CaseRow(
            f"{case}: least time, s",
            SIMPLER_LEAST_S,
            round(least_s, 1),
            abs(least_s / SIMPLER_LEAST_S - 1.0) <= OFF,
            criterion,
        ),
        CaseRow(
            f"{case}: static, {SIMPLER_TIMES:g} x least, kWh",
            SIMPLER_KWH,
            round(kwh, 2),
            short <= 0.0,
            of_energy,
        ),
    )


def _parameters() -> tuple[Parameter, ...]:
    return (
        Parameter("library", "TTOBench 1.5", "", "nuorail/ttobench, BSD-2"),
        Parameter("points of the run's mesh", POINTS, "", "as aboard; the budget of 20 ms is for this many"),
        Parameter("points of the bound's mesh", BOUND_POINTS, "", "assumed: its gap falls with their square"),
        Parameter(
            "deceleration without a limit in the file", 1.0, "m/s^2", "assumed: a metro's service brake"
        ),
        Parameter("train without a length", "a point", "", "the files; others by their length"),
        Parameter("adhesion, fading of the electric brake, auxiliaries", "none", "", "the files have none"),
        Parameter(
            "from and to", "first and last stop, at a stand", "", "the authors' instance; theirs at 1 m/s"
        ),
    )


REMARKS: Final = (
    "energy: of a run that the true laws allow on every metre, at the wire, net of what is fed back; bound: by weak"
    " duality, of the continuous problem",
    f"the run whose gap is judged has the {POINTS} points that a unit solves for, which the bench times; the bound"
    f" is a proof whatever it costs, so it is looked for with {BOUND_POINTS}. Gaps of one mesh alone stand beside",
    "stops between the first and the last are passed",
    "cross-check: theirs is the authors' problem (direct multiple shooting, dkouzoup/ms-eetc) put up and solved"
    f" anew on {FINE} intervals; on {COARSE} that came to each figure of their own code, which stands beside. What"
    " those are above ours is the mesh: the force is held on an interval, and its power binds at both ends",
    "by a simpler model: published rounded, without what it leaves out. Where its energy is below our bound, no run"
    " of this train on this track has it",
)


def library(options: Options) -> tuple[Mapping[str, TtobenchTrack], Mapping[str, BenchTrain]]:
    """Its tracks and trains; InputError where it is not there, or a file of it cannot be used."""
    folder = reference_folder(options, FOLDER)
    return read_tracks(folder / "tracks"), read_trains(folder / "trains")


def experiment(options: Options) -> Findings:
    """Run the instances, and those that others have figures of."""
    tracks, trains = library(options)
    rows: list[CaseRow] = []
    pairs: list[MeshPair] = []
    for track, train in _pairs(tracks, trains, quick=options.quick):
        for word, perfect in EFFICIENCIES:
            course = course_of(track, train, perfect=perfect)
            least_s = float(least_time(course).time_s[-1])
            found = [pair_of(course, share * least_s) for share in TIMES]
            rows.append(row_of(f"{track.id}, {train.id}, {word}", least_s, found))
            pairs += found
    checks = [cross_row(tracks[check.track], trains[CROSS_TRAIN], check) for check in CROSS_CHECKS]
    rows += [*checks, *_simpler_rows(tracks[SIMPLER_TRACK], trains[SIMPLER_TRAIN])]
    return Findings(rows, _parameters(), REMARKS, _figures(pairs))


def by_cruising(options: Options) -> Iterator[CaseRow]:
    """The instance of the null method, and its cross-checks."""
    tracks, trains = library(options)
    yield cruising_row(tracks[HELD[0]], trains[HELD[1]])
    for check in LOSSY:
        yield cross_row(tracks[check.track], trains[CROSS_TRAIN], check, cruising=True)


reproduce: Final = Specification(
    "ttobench",
    "Least energy on TTOBench's tracks, with a proven bound",
    experiment,
    NullMethod("full power to one cruising speed", (", ".join(HELD), *map(cross_case, LOSSY)), by_cruising),
    NotDriven("profiles alone"),
    f"quick: {len(QUICK)} instances of all tracks with all trains",
)
