"""A paper as a specification: what is sampled, what is run and judged, and the same experiment without the idea.

Every name of `REPRODUCTIONS` is a module of this package, and its `reproduce` is a `Specification`. Its null method is
a part of it and runs by itself, so that the tests can run it alone; `--out` and `--quick` mean the same for all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.errors import InputError
from papers.parameter_sets import NotDriven, ParameterSet
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, Reproduction, UnjudgedFigure
from study.record.directory import made_folder

# the module of each, imported only when asked for, has its name with _ for -
REPRODUCTIONS: Final = (
    "battery-day",
    "harada-accuracy",
    "harada-beacons",
    "harada-loop-track",
    "harada-slide",
    "journeys",
    "line-driving",
    "line-stops",
    "mochizuki-patterns",
    "mochizuki-speed",
    "oda-scale-track",
    "oda-table4",
    "oda-tuning",
    "oda-vision",
    "position-compare",
    "position-fusion",
    "position-operations",
    "stop-statistics",
    "stop-window",
    "sugiyama-table5",
    "sugiyama-tags",
    "trainruns",
    "ttobench",
    "virtual-blocks",
    "yasunobu-energy",
    "yasunobu-robust",
)
REPORTED: Final = "reported, not judged"


@dataclass(frozen=True, slots=True)
class Evenly:
    """A quantity that is drawn evenly between two values."""

    name: str
    low: float
    high: float
    unit: str
    origin: str

    @property
    def parameter(self) -> Parameter:
        """As a reproduction prints it."""
        return Parameter(self.name, f"{self.low:g} to {self.high:g}", self.unit, self.origin)

    def draw(self, rng: np.random.Generator) -> float:
        """One value of it."""
        return float(rng.uniform(self.low, self.high))

    def at(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        """The values at shares of the way from low to high."""
        return np.asarray(self.low + shares * (self.high - self.low), dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Findings:
    """What an experiment came to. `null`: rows of the null method where they come of the same runs; None: run it.

    `draw` writes charts and tables below the folder of `--out`.
    """

    rows: Iterable[CaseRow]
    parameters: Iterable[Parameter] = ()
    remarks: Iterable[str] = ()
    figures: Iterable[UnjudgedFigure] = ()
    null: Iterable[CaseRow] | None = None
    draw: Callable[[Path], Sequence[Path]] | None = None


@dataclass(frozen=True, slots=True)
class Specification:
    """One reproduction; called with options, it runs. `slice`: what `--quick` leaves out; `beside`: a second column.

    `driven`: by which set of parameters its trains are driven, or why by none. `whole`: cases whose criterion is of all
    runs, so that a slice tells them and judges them not.
    """

    name: str
    title: str
    run: Callable[[Options], Findings]
    null: NullMethod
    driven: ParameterSet | NotDriven
    slice: str = ""
    beside: str = ""
    whole: tuple[str, ...] = ()

    def __call__(self, options: Options) -> Reproduction:
        """Run the experiment and its null method, and draw if asked. InputError before, where nothing can be drawn."""
        with nullcontext() if options.out is None else made_folder(Path(options.out), Path(options.out)):
            found = self.run(options)
            null = self.null.run(options) if found.null is None else found.null
            rows, remarks = list(found.rows), list(found.remarks)
            if options.out is not None and found.draw is not None:
                remarks.append("drawn: " + ", ".join(path.name for path in found.draw(Path(options.out))))
            left_out = self.slice if options.quick else ""
            if left_out:
                remarks.append(left_out)
                rows = [_of_slice(row) if row.case in self.whole else row for row in rows]
            return Reproduction(
                self.name,
                self.title,
                (*found.parameters, *self.driven.parameters()),
                (*rows, *self.null.rows(null)),
                tuple(remarks),
                tuple(found.figures),
                self.beside,
                left_out,
                null=self.null,
            )


def _of_slice(row: CaseRow) -> CaseRow:
    criterion = f"of all runs, not judged of some: {row.criterion}"
    return replace(row, passed=True, judged=False, criterion=criterion)


def reproduction(name: str) -> Specification:
    """The reproduction of a name; InputError with the known names otherwise."""
    if name not in REPRODUCTIONS:
        raise InputError("reproduce", "name", name, "one of " + ", ".join(REPRODUCTIONS))
    found: Specification = import_module(f"papers.{name.replace('-', '_')}").reproduce
    return found


def at_most(case: str, paper: object, ours: float, limit: float, digits: int = 4) -> CaseRow:
    """A figure that must not be above a limit."""
    return CaseRow(case, paper, round(ours, digits), ours <= limit, f"at most {limit:g}")


def none_of(case: str, count: int, criterion: str = "none", paper: object = None) -> CaseRow:
    """Something that must not happen."""
    return CaseRow(case, paper, count, count == 0, criterion)


def equal_figure(case: str, paper: object, ours: object, criterion: str = "equal") -> CaseRow:
    """A figure that must be the paper's."""
    return CaseRow(case, paper, ours, ours == paper, criterion)


def reported_figure(case: str, ours: object, what: str, paper: object = None) -> CaseRow:
    """A figure that has no criterion."""
    return CaseRow(case, paper, ours, True, f"{what}; {REPORTED}", judged=False)
