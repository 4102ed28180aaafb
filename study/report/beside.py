"""Another run of the same line, drawn under this one."""

from __future__ import annotations

from dataclasses import dataclass, field

from study.report.data import ReportedRun


@dataclass(frozen=True, slots=True)
class Beside:
    """A run by its name, with the numbers of trains that moved from it to this one, and of those only there."""

    label: str
    run: ReportedRun
    moved: frozenset[str] = field(default=frozenset())
    gone: frozenset[str] = field(default=frozenset())
