"""The common form of a reproduction: parameters with their origin, and the paper's figures beside ours."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field, replace
from typing import Any


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of an experiment; `origin` is the paper's section or table, a data file, or 'assumed: why'."""

    name: str
    value: float | int | str | bool
    unit: str
    origin: str


@dataclass(frozen=True, slots=True)
class CaseRow:
    """One case: what the paper says, what we found, and whether ours passes the stated criterion.

    `judged` False: the same case under another assumption, which is reported; it has `passed` set.
    """

    case: str
    paper: object
    ours: object
    passed: bool
    criterion: str = ""
    beside: object = None  # the same case in the second column, where there is one
    judged: bool = True


@dataclass(frozen=True, slots=True)
class NullMethod:
    """The same experiment without the idea, in a few words, and how cases end whose criterion it must not meet.

    A criterion that is met without the idea says nothing of it. The null method is run beside, judged by the same
    functions, and its rows say the opposite: they pass where it fails. `run` gives its rows, judged as the method is.
    """

    name: str
    fails: tuple[str, ...]
    run: Callable[[Options], Iterable[CaseRow]] = lambda _options: ()

    def rows(self, judged: Iterable[CaseRow]) -> tuple[CaseRow, ...]:
        """The rows to print, of those of its own run, judged as the method is."""
        return tuple(
            replace(
                row,
                case=self.case(row.case),
                passed=not row.passed,
                criterion=f"must not be met: {row.criterion}",
            )
            for row in judged
            if row.case.endswith(self.fails)
        )

    def case(self, case: str) -> str:
        """What the row of a case is called."""
        return f"null method, {self.name}: {case}"


@dataclass(frozen=True, slots=True)
class UnjudgedFigure:
    """A figure that is reported and not judged, and what it says."""

    name: str
    value: object
    meaning: str


@dataclass(frozen=True, slots=True)
class Reproduction:
    """The result of `branchline reproduce NAME`; `beside` heads the rows' second column, empty: there is none.

    `slice`: what was left out, empty: nothing. `rows` have those of the null method among them, else ValueError.
    """

    name: str
    title: str
    parameters: tuple[Parameter, ...]
    rows: tuple[CaseRow, ...]
    remarks: tuple[str, ...] = ()
    figures: tuple[UnjudgedFigure, ...] = ()
    beside: str = ""
    slice: str = ""
    null: NullMethod = field(kw_only=True)

    def __post_init__(self) -> None:
        cases = [row.case for row in self.rows if row.case.startswith(self.null.case(""))]
        absent = [end for end in self.null.fails if not any(case.endswith(end) for case in cases)]
        if absent or not self.null.fails:
            raise ValueError(
                f"{self.name}: the null method, {self.null.name}, has no row of {absent or 'any case'}"
            )

    @property
    def passed(self) -> bool:
        """Whether every row passed."""
        return all(row.passed for row in self.rows)

    def as_dict(self) -> dict[str, Any]:
        """What `--json` prints."""
        return {
            "name": self.name,
            "title": self.title,
            "passed": self.passed,
            "null_method": self.null.name,
            "slice": self.slice,
            "parameters": [asdict(parameter) for parameter in self.parameters],
            "rows": [
                {
                    "case": r.case,
                    "paper": r.paper,
                    "ours": r.ours,
                    **({self.beside: r.beside} if self.beside else {}),
                    "passed": r.passed,
                    "judged": r.judged,
                    "criterion": r.criterion,
                }
                for r in self.rows
            ],
            "figures": [asdict(figure) for figure in self.figures],
            "remarks": list(self.remarks),
        }


@dataclass(frozen=True, slots=True)
class Options:
    """What the command line hands to a reproduction."""

    seed: int = 1
    link: str = "simulated"
    out: str | None = None
    data: str | None = None  # where reference data of others lies, see `reference_data`
    quick: bool = False  # a short slice for CI; says so in its remarks
