"""The common form of a reproduction: parameters with their origin, and the paper's figures beside ours."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any, Final

from network.errors import InputError

# name -> module whose `reproduce` is a `papers.specification.Specification`, or a function beside the module's `NULL`;
# imported only when asked for
REPRODUCTIONS: Final[Mapping[str, str]] = {
    "journeys": "papers.journeys",
    "line-driving": "papers.line_driving",
    "battery-day": "papers.battery_day",
    "harada-accuracy": "papers.harada_accuracy",
    "harada-beacons": "papers.harada_beacons",
    "harada-loop-track": "papers.harada_loop_track",
    "harada-slide": "papers.harada_slide",
    "line-stops": "papers.line_stops",
    "mochizuki-patterns": "papers.mochizuki_patterns",
    "mochizuki-speed": "papers.mochizuki_speed",
    "position-operations": "papers.position_operations",
    "oda-scale-track": "papers.oda_scale_track",
    "oda-table4": "papers.oda_table4",
    "oda-tuning": "papers.oda_tuning",
    "oda-vision": "papers.oda_vision",
    "position-compare": "papers.position_compare",
    "position-fusion": "papers.position_fusion",
    "stop-statistics": "papers.stop_statistics",
    "stop-window": "papers.stop_window",
    "sugiyama-table5": "papers.sugiyama_table5",
    "sugiyama-tags": "papers.sugiyama_tags",
    "trainruns": "papers.trainruns",
    "yasunobu-robust": "papers.yasunobu_robust",
    "ttobench": "papers.ttobench",
    "virtual-blocks": "papers.virtual_blocks",
    "yasunobu-energy": "papers.yasunobu_energy",
}


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

    `judged` False: the same case under another assumption, which is told; it has `passed` set.
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
    """A figure that is told and not judged, and what it says."""

    name: str
    value: object
    meaning: str


@dataclass(frozen=True, slots=True)
class Reproduction:
    """The result of `branchline reproduce NAME`; `beside` heads the rows' second column, empty: there is none.

    `rows` have those of the null method among them, else ValueError.
    """

    name: str
    title: str
    parameters: tuple[Parameter, ...]
    rows: tuple[CaseRow, ...]
    remarks: tuple[str, ...] = ()
    figures: tuple[UnjudgedFigure, ...] = ()
    beside: str = ""
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
            "parameters": [
                {"name": p.name, "value": p.value, "unit": p.unit, "origin": p.origin}
                for p in self.parameters
            ],
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
            "figures": [{"name": f.name, "value": f.value, "meaning": f.meaning} for f in self.figures],
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


def reproduction(name: str) -> Callable[[Options], Reproduction]:
    """The function that runs a reproduction; InputError with the known names otherwise."""
    module = REPRODUCTIONS.get(name)
    if module is None:
        raise InputError("reproduce", "name", name, "one of " + ", ".join(sorted(REPRODUCTIONS)))
    function: Callable[[Options], Reproduction] = import_module(module).reproduce
    return function
