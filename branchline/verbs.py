"""What `import branchline` gives: the verbs, and what they return. Wrong input is an `InputError` everywhere."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import polars as pl

from branchline.checked_call import checked_call
from branchline.comparing import check_over
from branchline.questions import ALL_CUTS, CapacityAsked, LineCapacity, LineHeadways, capacity_of, headways_of
from branchline.sources import loaded_source
from branchline.whole_run import RunAsked, run_whole
from branchline.whole_sweep import SweepAsked, run_sweep
from network.errors import InputError
from network.files.shipped import shipped_line
from network.model import Line
from network.patching.patch import load_patched_line
from papers.reproduction import Options, Reproduction
from papers.specification import reproduction
from scenario.layers import KEYWORDS
from scenario.scenario import Scenario, load_scenario
from study.compare.comparison import Comparisons, verdict_of
from study.compare.comparison import compare as compared
from study.compare.files import write_comparison
from study.compare.graph import draw_both
from study.compare.side import read_sides
from study.feasibility.check import feasibility
from study.feasibility.finding import Feasibility
from study.plot.choice import Choice, time_of
from study.plot.kinds import kind_of
from study.plot.write import picture_of
from study.record.directory import REPORT_FILE
from study.record.read_back import RunRead, read_run
from study.record.tables import RunTables
from study.report.drawn import DrawnFigure
from study.report.style import drawing
from study.sweep.go import SweepProgress
from study.sweep.plan import load_plan
from study.sweep.report import DAYS_FILE, POINTS_FILE
from study.wording.phrase import Language


@dataclass(frozen=True, slots=True)
class CheckedPlan:
    """What `check` finds in a plan before it runs."""

    scenario: Scenario
    found: Feasibility

    def __repr__(self) -> str:
        """In a notebook: the verdict."""
        return f"<plan of {self.scenario.id}: {self.found.verdict}>"

    @property
    def good(self) -> bool:
        """Whether the plan can work."""
        return self.found.good

    @property
    def meets(self) -> pl.DataFrame:
        """A row a meet of two trains."""
        return _frame([meet.as_dict() for meet in self.found.meets])

    @property
    def findings(self) -> pl.DataFrame:
        """A row for each thing that cannot work, or is tight, with what would mend it."""
        return _frame([finding.as_dict() for finding in self.found.findings])


@dataclass(frozen=True, slots=True)
class OpenedRun:
    """A finished run: its directory, summary and tables. `read` has all else, its line and timetable among it."""

    read: RunRead

    def __repr__(self) -> str:
        """In a notebook: what it is of, where, and how it ended."""
        broken = self.summary["broken"]
        return f"<run of {self.summary['scenario']} in {self.directory}: {'; '.join(broken) or 'good'}>"

    @property
    def directory(self) -> Path:
        """Where it is."""
        return self.read.directory

    @property
    def report(self) -> Path:
        """Its page."""
        return self.directory / REPORT_FILE

    @property
    def summary(self) -> dict[str, Any]:
        """Its figures by name: docs/tables.md."""
        return dict(self.read.summary)

    @property
    def tables(self) -> RunTables:
        """Its tables as polars frames, each read when it is asked for: docs/tables.md."""
        return self.read.tables

    @property
    def good(self) -> bool:
        """Whether nothing was broken and everybody arrived."""
        return not self.summary["broken"]

    @checked_call
    def picture(
        self,
        kind: str,
        *,
        train: str | None = None,
        station: str | None = None,
        from_time: str | None = None,
        to_time: str | None = None,
        language: Language = "en",
    ) -> DrawnFigure:
        """A picture as `branchline plot` draws it; `branchline plot list` has the kinds. InputError."""
        window_s = time_of("from_time", from_time), time_of("to_time", to_time)
        return picture_of(self.read, kind_of(kind), Choice(train, station, *window_s, language))


@dataclass(frozen=True, slots=True)
class RunsCompared:
    """What differs between runs; the first is what the others are compared with."""

    found: Comparisons

    def __repr__(self) -> str:
        """In a notebook: what changed."""
        return f"<{' '.join(self.verdict)}>"

    @property
    def verdict(self) -> tuple[str, ...]:
        """What changed, in sentences; of several runs all of the first, then of the next."""
        return tuple(text for pair in self.found.pairs for text in verdict_of(pair))

    @property
    def figures(self) -> pl.DataFrame:
        """A row a figure, a column a run."""
        labels = [side.label for side in self.found.sides]
        return _frame(
            [
                {
                    "group": m.group,
                    "figure": m.name,
                    "unit": m.unit,
                    **dict(zip(labels, m.values, strict=True)),
                }
                for m in self.found.measures
            ]
        )

    @property
    def times(self) -> pl.DataFrame:
        """A row for each arrival and departure that moved, with its run."""
        return _frame(
            [{"run": pair.new, **row.as_dict()} for pair in self.found.pairs for row in pair.times.moved]
        )

    @checked_call
    def picture(self, number: int = 1) -> DrawnFigure:
        """The train graphs of the first run and another on one sheet. InputError for a number of no other run."""
        if not 1 <= number <= len(self.found.pairs):
            raise InputError("picture", "number", number, f"1 to {len(self.found.pairs)}")
        with drawing():
            figure = draw_both(self.found.sides[0], self.found.sides[number], self.found.pairs[number - 1])
            return DrawnFigure(figure, f"train_graph_{number}")

    def write(self, out: str | Path) -> Path:
        """Write the directory that `branchline compare --out` writes; returns its page."""
        return write_comparison(self.found, Path(out).resolve())


@dataclass(frozen=True, slots=True)
class SweptDays:
    """A sweep and its days, in its directory."""

    state: SweepProgress
    report: Path

    def __repr__(self) -> str:
        """In a notebook: where its page is."""
        return f"<sweep {self.report}: {'good' if self.good else 'not good'}>"

    @property
    def good(self) -> bool:
        """Whether no day crashed or broke a rule."""
        return not self.state.failures

    @property
    def days(self) -> pl.DataFrame:
        """A row a day that counts."""
        return pl.read_csv(self.report.with_name(DAYS_FILE), infer_schema_length=None)

    @property
    def points(self) -> pl.DataFrame:
        """A row a point and figure: mean and quantiles with their intervals, difference from the first point."""
        return pl.read_csv(self.report.with_name(POINTS_FILE), infer_schema_length=None)


@checked_call
def load(name: str | Path, *, seed: int | None = None, **tables: object) -> Scenario:
    """A scenario by name or file, changed by the tables of scenario files as keywords: docs/files/scenario.md.

    `load("karasuyama_weekday", people={"react": False}, patch={"line": {"add_loops": ["NIT"]}})` is what a file that
    extends it would be; files that it names are looked for in the working directory.
    """
    return load_scenario(str(name), seed, tables)


@checked_call
def check(scenario: str | Path | Scenario) -> CheckedPlan:
    """Look at a plan without running it: where trains meet, what is impossible, late or tight."""
    loaded = _scenario(scenario)
    return CheckedPlan(loaded, feasibility(loaded.setup))


@checked_call
def run(
    scenario: str | Path | Scenario,
    out: str | Path | None = None,
    *,
    link: str = "simulated",
    carrier: str = "sumo",
    anyway: bool = False,
    progress: bool = False,
) -> OpenedRun:
    """Run a day into its directory, by default runs/<id>, and open it. Options mean what they do for `branchline run`.

    Raises InputError for a plan that cannot work, CutShortError where the run could not go on.
    """
    loaded = _scenario(scenario)
    directory = Path("runs") / loaded.id if out is None else Path(out)
    run_whole(
        loaded, directory.resolve(), RunAsked(link=link, carrier=carrier, anyway=anyway), progress=progress
    )
    return open(directory)


@checked_call
def open(directory: str | Path) -> OpenedRun:  # noqa: A001 - branchline.open, as the open of other libraries
    """A finished run. InputError for a directory of anything else."""
    return OpenedRun(read_run(Path(directory)))


@checked_call
def compare(
    base: str | Path | OpenedRun,
    other: str | Path | OpenedRun,
    *more: str | Path | OpenedRun,
    over_s: float = 1.0,
) -> RunsCompared:
    """What changed from a run to others of the same line; times that moved by no more than `over_s` are left out."""
    check_over(over_s)
    runs = (base, other, *more)
    directories = [each.directory if isinstance(each, OpenedRun) else Path(each) for each in runs]
    return RunsCompared(compared(read_sides(directories), over_s))


@checked_call
def sweep(
    file: str | Path,
    out: str | Path | None = None,
    *,
    days: int | None = None,
    jobs: int | None = None,
    carrier: str | None = None,
    progress: bool = False,
) -> SweptDays:
    """Run the missing days of a sweep, by name or file (docs/sweeps.md), into a directory, by default sweeps/<id>."""
    how = SweepAsked(jobs, carrier)
    plan = load_plan(str(file), days, how.carrier)
    directory = Path("sweeps") / plan.table.id if out is None else Path(out)
    return SweptDays(*run_sweep(plan, directory.resolve(), how, progress=progress))


@checked_call
def headway(
    source: str | Path | Scenario | OpenedRun, station: str | None = None, *, theory: bool = False
) -> LineHeadways:
    """The least headways of a line, or of one station by id or name.

    A scenario is run for them, with `theory` it is not; of a finished run they are read.
    """
    return headways_of(_source(source), station, theory=theory)


@checked_call
def capacity(
    source: str | Path | Scenario | OpenedRun,
    *,
    cut: str = ALL_CUTS,
    from_time: str | None = None,
    to_time: str | None = None,
    theory: bool = False,
) -> LineCapacity:
    """How full each part of a line is by the ways it can be cut (UIC 406), and what more fits.

    Of the day and its peak, or from one time to another, HH:MM.
    """
    between_s = time_of("from_time", from_time), time_of("to_time", to_time)
    return capacity_of(_source(source), CapacityAsked(cut, between_s, theory=theory))


@checked_call
def reproduce(
    name: str, out: str | Path | None = None, *, seed: int = 1, quick: bool = False
) -> Reproduction:
    """A published experiment repeated, with the published figures beside ours; charts go into a directory `out`."""
    return reproduction(name)(Options(seed=seed, out=None if out is None else str(out), quick=quick))


@checked_call
def line(name: str | Path, **patch: object) -> Line:
    """A line by name or file, changed by the words of a `[patch.line]` as keywords: docs/files/line.md."""
    return load_patched_line(shipped_line(str(name)), patch, str(KEYWORDS))


def _scenario(scenario: str | Path | Scenario) -> Scenario:
    return scenario if isinstance(scenario, Scenario) else load_scenario(str(scenario))


def _source(source: str | Path | Scenario | OpenedRun) -> Scenario | RunRead:
    return loaded_source(source.read if isinstance(source, OpenedRun) else source)


def _frame(rows: list[dict[str, Any]]) -> pl.DataFrame:
    """A column a key; of no rows, no columns."""
    return pl.DataFrame(rows, infer_schema_length=None)
