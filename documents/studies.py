"""The figures and pictures of docs/studies: `python -m documents.studies RUNS` writes them into the pages.

A page is written by hand but for its blocks, each between `<!-- made: NAME -->` and `<!-- /made -->`. Blocks of theory,
and of days that are kept, take seconds and are compared with the committed ones by a test; those of runs are made from
run directories in RUNS, `RUNS/NAME` of each scenario, which are made where they are missing, and are compared at night.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np
import polars as pl

from documents import crossings_study, order_of_trains, second_loop, studies_pictures
from documents.studies_pictures import HeadwayByCase
from network.timetable import Timetable, seconds_of
from scenario.scenario import load_scenario
from simulation.setup import Setup
from study.capacity.cut import cut_of
from study.capacity.headway import HeadwayCase, HeadwayKind, line_cases
from study.capacity.legs import legs_of, places_of
from study.capacity.line_capacity import Period, rates_of
from study.capacity.rules import MINIMAL
from study.capacity.theory import occupations
from study.measures.missing import planned_times
from study.record.read_back import RunRead, read_run
from study.report.data import ReportedRun
from study.runner.run import PartyLink, execute, write_run

ROOT: Final = Path(__file__).resolve().parents[1]
FOLDER: Final = ROOT / "docs" / "studies"
LOOPS: Final = tuple(f"second_loop/{name}" for name, _, _ in second_loop.CASES)
RADIO: Final = (
    "karasuyama_weekday",
    *(f"tags_and_radio/{name}" for name in ("half_tags", "slow_radio", "both")),
)
DENSE: Final = ("second_loop/loop_at_hanaoka", "tags_and_radio/dense_slow_radio")
CABLE: Final = tuple(f"cut_cable/{name}" for name in ("on_board", "relay", "central", "central_beyond"))
CUT_S: Final = (seconds_of("", "", "10:50", None), seconds_of("", "", "17:00", None))
_DAY_S: Final = (7 * 3600, 20 * 3600)  # in which the even timetables are full
_MARK: Final = re.compile(r"(<!-- made: ([\w-]+) -->\n).*?(<!-- /made -->)", re.DOTALL)
LATE_S: Final = 5.0
_STATED: Final = MappingProxyType(
    {
        "before": "as it is",
        "loop_at_hanaoka": "loop at Shimotsuke-Hanaoka",
        "loop_at_niita": "loop at Niita",
        "karasuyama_weekday": "as it is",
        "half_tags": "43 of 76 tags",
        "slow_radio": "2 s radio",
        "both": "both",
        "dense_slow_radio": "2 s radio",
        "on_board": "on board",
        "relay": "relay, worked by staff",
        "central": "central",
        "central_beyond": "central, cut beyond Ogane",
    }
)


def scenario_of(name: str) -> str:
    """What the commands call a scenario: a shipped one, or a file of a study."""
    return str(FOLDER / f"{name}.toml") if "/" in name else name


def study_label(name: str) -> str:
    """What tables and pictures call it."""
    return _STATED[name.rpartition("/")[2]]


# theory -----------------------------------------------------------------------------------------------------


def occupation() -> Iterator[str]:
    """Occupancy time rates of the three even timetables, by stretch between loops."""
    yield "| timetable | stretch | trains | occupied | rate |"
    yield "|---|---|---|---|---|"
    for name in LOOPS:
        setup = load_scenario(scenario_of(name)).setup
        legs = legs_of(occupations(setup, MINIMAL), places_of(setup.line))
        period = Period("chosen", *_DAY_S, peak=False)
        for rate in rates_of(legs, cut_of(setup.line, "crossing"), (period,)):
            occupied_min = rate.compressed.occupied_s / 60
            part = rate.part.name.replace(" - ", " – ")
            yield (
                f"| {study_label(name)} | {part} | {rate.trains} | {occupied_min:.0f} min"
                f" | {100 * rate.occupied_share:.0f} % |"
            )


def choices(loops: Sequence[Sequence[str]] = second_loop.CHOICES) -> Iterator[str]:
    """Where a second loop helps, and by how much."""
    return second_loop.table(loops)


def pairs(names: Sequence[str] = RADIO) -> list[HeadwayByCase]:
    """All headways of the day, in every case."""
    found: list[dict[tuple[str, HeadwayKind, str, str], HeadwayCase]] = []
    for name in names:
        setup: Setup = load_scenario(scenario_of(name)).setup
        cases = line_cases(setup.line, occupations(setup, MINIMAL), setup.unit.dwell_min_s)
        found.append({(c.station_id, c.headway.kind, c.first, c.second): c for c in cases})
    return [
        HeadwayByCase(
            *key,
            tuple(each[key].headway.least_s for each in found),
            tuple(each[key].headway.costs_s for each in found),
        )
        for key in found[0]
        if all(key in each for each in found)
    ]


def headways() -> Iterator[str]:
    """Least headways, and what they are longer by."""
    yield (
        f"| at | headway | {study_label(RADIO[0])} | "
        + " | ".join(study_label(name) for name in RADIO[1:])
        + " |"
    )
    yield "|---|---|" + "---|" * len(RADIO)
    for pair in pairs():
        base_s, *others_s = pair.least_s
        more = " | ".join(f"{s - base_s:+.1f}" for s in others_s)
        yield f"| {pair.station} | {pair.kind} {pair.first} / {pair.second} | {base_s:.1f} s | {more} |"


# runs -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class StudyRuns:
    """The run directories of the studies, made where they are missing."""

    folder: Path

    def run_named(self, name: str) -> RunRead:
        """One run, read back."""
        where = self.folder / name.rpartition("/")[2]
        if not where.exists():
            scenario = load_scenario(scenario_of(name))
            write_run(execute(scenario, PartyLink.SIMULATED), where)
        return read_run(where)


def last_calls(stops: pl.DataFrame) -> pl.DataFrame:
    """The last call of every train with passengers."""
    return stops.filter("revenue").group_by("train", maintain_order=True).last()


def arrived_of(stops: pl.DataFrame) -> int:
    """How many trains came to their last call."""
    return last_calls(stops)["arrival_s"].drop_nulls().len()


def arrivals_of(stops: pl.DataFrame, timetable: Timetable, end_s: float | None = None) -> pl.DataFrame:
    """Planned arrivals of trains with passengers, with how late they came; see `study.measures.missing`."""
    with_passengers = [number for number, train in timetable.trains.items() if train.revenue]
    times = planned_times(stops, timetable, end_s)
    return times.filter(pl.col("what") == "arrival", pl.col("train").is_in(with_passengers))


def mean_late_s(run: RunRead) -> float:
    """Of all planned arrivals of trains with passengers, s."""
    return mean_of(arrivals_of(run.tables.stops, run.timetable, run.summary.get("latest_end_s"))["late_s"])


def lost_min(stops: pl.DataFrame, timetable: Timetable, end_s: float | None = None) -> float:
    """Train-minutes lost: by how much trains came late to their last stop, together."""
    last = pl.DataFrame(
        [(train.number, train.calls[-1].station_id) for train in timetable.trains.values()],
        schema=("train", "station"),
        orient="row",
    )
    times = arrivals_of(stops, timetable, end_s).join(last, on=["train", "station"], how="semi")
    return float(times["late_s"].clip(0).sum()) / 60.0


def arrived_within(stops: pl.DataFrame, from_s: float, to_s: float, column: str = "arrival_s") -> int:
    """Trains that came to their last stop, or were to come there, within that time."""
    return last_calls(stops).filter(pl.col(column).is_between(from_s, to_s)).height


def mean_of(values: pl.Series) -> float:
    """The mean of those that are there."""
    return float(np.mean(values.drop_nulls().to_numpy()))


def loop_runs(runs: StudyRuns) -> Iterator[str]:
    """Whether the even timetables run."""
    yield "| timetable | trains | arrived | latest | mean lateness at stops |"
    yield "|---|---|---|---|---|"
    for name in LOOPS:
        run = runs.run_named(name)
        stops, late_s = run.tables.stops.filter("revenue"), mean_late_s(run)
        arrived = arrived_of(stops)
        late_max_s = run.summary["late_s_max"]
        yield (
            f"| {study_label(name)} | {last_calls(stops).height} | {arrived} | {late_max_s:.1f} s"
            f" | {late_s:+.1f} s |"
        )


def radio_runs(runs: StudyRuns) -> Iterator[str]:
    """What tags and radio cost on the weekday as it is planned."""
    yield "| case | arrived | latest | stop error, mean ± sigma | largest | sections held, mean | telegrams |"
    yield "|---|---|---|---|---|---|---|"
    for name in RADIO:
        run = runs.run_named(name)
        summary, stops = run.summary, run.tables.stops
        held_s = mean_of(run.tables.blocks["released_s"] - run.tables.blocks["granted_s"])
        sent = sum(row["sent"] for row in run.tables.telegrams.iter_rows(named=True))
        yield (
            f"| {study_label(name)} | {arrived_of(stops)} | {summary['late_s_max']:.1f} s"
            f" | {summary['stop_error_m_mean']:.2f} ± {summary['stop_error_m_sigma']:.2f} m"
            f" | {summary['stop_error_m_max_abs']:.2f} m | {held_s:.0f} s | {sent} |"
        )


def dense_runs(runs: StudyRuns) -> Iterator[str]:
    """The same where trains wait for each other at every loop."""
    yield "| every 26 min | arrived | latest | mean lateness at stops | departures > 5 s late |"
    yield "|---|---|---|---|---|"
    for name, radio in zip(DENSE, ("0.2 s radio", "2 s radio"), strict=True):
        run = runs.run_named(name)
        stops, late_s = run.tables.stops.filter("revenue"), mean_late_s(run)
        left_late = stops.filter(pl.col("late_departure_s") > LATE_S).height
        yield (
            f"| {radio} | {arrived_of(stops)} | {run.summary['late_s_max']:.1f} s"
            f" | {late_s:+.1f} s"
            f" | {left_late} of {stops['late_departure_s'].drop_nulls().len()} |"
        )


def cable_runs(runs: StudyRuns) -> Iterator[str]:
    """Trains run and train-minutes lost with the cable cut."""
    yield "| interlocking | to arrive 10:50–17:00 | arrived then | arrived in the end | train-minutes lost | latest |"
    yield "|---|---|---|---|---|---|"
    for name in CABLE:
        run = runs.run_named(name)
        stops = run.tables.stops
        last, lost = last_calls(stops), lost_min(stops, run.timetable, run.summary.get("latest_end_s"))
        yield (
            f"| {study_label(name)} | {arrived_within(stops, *CUT_S, 'planned_arrival_s')}"
            f" | {arrived_within(stops, *CUT_S)} | {last['arrival_s'].drop_nulls().len()} of {last.height}"
            f" | {lost:.0f} | {run.summary['late_s_max'] / 3600:.2f} h |"
        )


THEORY: Final[Mapping[str, Callable[[], Iterator[str]]]] = MappingProxyType(
    {"choices": choices, "occupation": occupation, "headways": headways, "orders": order_of_trains.table}
)
OF_RUNS: Final[Mapping[str, Callable[[StudyRuns], Iterator[str]]]] = MappingProxyType(
    {
        "loop-runs": loop_runs,
        "radio-runs": radio_runs,
        "dense-runs": dense_runs,
        "cable-runs": cable_runs,
        "crossing-runs": lambda runs: crossings_study.table(runs.run_named),
        "crossings-by-hand": lambda runs: crossings_study.by_hand(runs.run_named),
    }
)


def blocks_in(text: str) -> dict[str, str]:
    """The made blocks of a page, by name."""
    return {
        match[2]: match[0].removeprefix(match[1]).removesuffix(match[3]) for match in _MARK.finditer(text)
    }


def with_blocks(text: str, made: Mapping[str, str]) -> str:
    """The page with these blocks; others stay as they are."""

    def block(match: re.Match[str]) -> str:
        return match[1] + made[match[2]] + match[3] if match[2] in made else match[0]

    return _MARK.sub(block, text)


def block_text(rows: Iterator[str]) -> str:
    """A block as it stands in a page."""
    return "".join(f"{row}\n" for row in rows)


def _shown(runs: StudyRuns, names: Sequence[str]) -> list[tuple[str, ReportedRun]]:
    found = [(study_label(name), runs.run_named(name)) for name in names]
    return [(label, ReportedRun(run.line, run.timetable, run.tables)) for label, run in found]


def main(arguments: Sequence[str]) -> None:
    """Write all blocks, and draw the pictures, from the runs in a folder."""
    runs = StudyRuns(Path(arguments[0]))
    made = {name: block_text(rows()) for name, rows in THEORY.items()}
    made |= {name: block_text(rows(runs)) for name, rows in OF_RUNS.items()}
    for page in sorted(FOLDER.glob("*.md")):
        page.write_text(with_blocks(page.read_text("utf-8"), made), "utf-8")
    studies_pictures.train_graphs(
        FOLDER / "second_loop" / "train_graphs.png",
        _shown(runs, LOOPS),
        (8 * 3600.0, 11 * 3600.0),
    )
    studies_pictures.headways(
        FOLDER / "tags_and_radio" / "headways.png", pairs(), [study_label(name) for name in RADIO[1:]]
    )
    studies_pictures.train_graphs(
        FOLDER / "cut_cable" / "train_graphs.png",
        _shown(runs, CABLE),
        (10 * 3600.0, 19.5 * 3600.0),
        CUT_S,
    )
    crossings_study.picture(FOLDER / "level_crossings" / "warnings.png", runs.run_named)


if __name__ == "__main__":
    main(sys.argv[1:])
