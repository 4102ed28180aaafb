"""The table of docs/studies/steps-left-out.md: `python -m documents.steps_left_out` runs its days and writes it.

Each step of the procedure is left out by itself, on three days of the Karasuyama line. That two trains are in one
section is found twice: by the checkers, and here from the positions of all trains alone.
"""

from __future__ import annotations

import sys
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from types import MappingProxyType
from typing import Final

from network.model import Line
from scenario.scenario import Scenario, load_scenario
from simulation.events import Danger, Left, Unsafe
from simulation.judge.log import Checker
from simulation.procedure import PROCEDURES, Regime, WorkingStep
from simulation.result import RunResult, TraceSpan
from simulation.setup import STEPS_PER_S
from simulation.substitute_settings import LeftOutStep
from study.drilling.drill import find_drill
from study.runner.run import CarrierKind, PartyLink, execute

FILE: Final = Path("docs/studies/steps-left-out.md")
UNTIL_S: Final = 9.5 * 3600.0  # substitute working is over, and trains run by authority again
DAYS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "as it comes": "karasuyama/95_substitute_working",
        "a train stands in the section": "karasuyama/95b_train_in_the_section",
        "the way on opens late": "karasuyama/95c_way_on_opens_late",
    }
)
BEGIN_MARK, END_MARK = "<!-- made: left-out -->\n", "<!-- /made -->"


@dataclass(frozen=True, slots=True)
class LeftOutOutcome:
    """What came of a run: whether two trains were in one section, by positions and by the checkers; rules broken."""

    by_positions: tuple[tuple[str, str], ...]
    by_checkers: bool
    pilots_rule: bool
    others: tuple[str, ...]
    unsafe: tuple[str, ...]
    arrived: int

    @property
    def words(self) -> str:
        """For a cell of the table."""
        said: list[str] = []
        if self.by_positions:
            said.append("**two trains in " + ", ".join(dict.fromkeys(s for s, _ in self.by_positions)) + "**")
        said += [f"a train {text}" for text in dict.fromkeys(self.unsafe)]
        rules = (["one-train-a-section"] if self.by_checkers else []) + (
            [Checker.PILOTS_LEAVE.value] if self.pilots_rule else []
        )
        seen = ", ".join((*rules, *self.others))
        said.append(f"checkers: {seen}" if seen else "checkers: nothing")
        return "; ".join([*said, f"{self.arrived} trains"])


def without(scenario: Scenario, *steps: LeftOutStep, until_s: float = UNTIL_S) -> Scenario:
    """The scenario's day up to a time, with these steps left out. ValueError where nobody works by substitute."""
    setup = scenario.setup
    if setup.substitute is None:
        raise ValueError(f"{scenario.id} has no [substitute]")
    substitute = setup.substitute.model_copy(update={"left_out": steps})
    return replace(scenario, setup=replace(setup, substitute=substitute, until_s=until_s))


def outcome_of(scenario: Scenario) -> LeftOutOutcome:
    """Run it and look."""
    result = execute(scenario, PartyLink.SIMULATED, carrier=CarrierKind.PLAIN).result
    kinds = [violation.checker for violation in result.violations]
    named = (Checker.ONE_TRAIN_A_SECTION.value, Checker.PILOTS_LEAVE.value)
    unsafe = tuple(e.event.text for e in result.journal.entries if isinstance(e.event, Unsafe))
    return LeftOutOutcome(
        shared_sections(result, scenario.setup.line, scenario.setup.lengths_m),
        named[0] in kinds,
        named[1] in kinds,
        tuple(dict.fromkeys(kind for kind in kinds if kind not in named)),
        unsafe,
        len(result.trains_arrived),
    )


def shared_sections(
    result: RunResult, line: Line, lengths_m: Mapping[str, float]
) -> tuple[tuple[str, str], ...]:
    """Sections in which two trains were at once, with the two: from their positions alone, second by second.

    Of a train that points sent elsewhere than its way leads nothing is known from then on, until its next train.
    """
    slots = range(len(result.stock_ids))
    spans: dict[int, list[TraceSpan]] = {slot: [s for s in result.spans if s.slot == slot] for slot in slots}
    under: dict[int, frozenset[str]] = {}
    found: dict[tuple[str, str], None] = {}
    leaves, astray = _when(result, Left), _when(result, Unsafe, Danger.WRONG_WAY)
    rows = zip(
        result.trace["step"].tolist(),
        result.trace["slot"].tolist(),
        result.trace["position_m"].tolist(),
        strict=True,
    )
    for step, slot, position_m in sorted(rows):
        for gone in [s for s in under if any(at <= step and s == who for at, who in leaves)]:
            del under[gone]
        leaves = [(at, who) for at, who in leaves if at > step]
        mine = spans[slot]
        at = bisect_right([span.from_step for span in mine], step - 1) - 1
        if at < 0:
            continue
        if any(mine[at].from_step <= strays < step for strays, who in astray if who == slot):
            under.pop(slot, None)
            continue
        length_m = lengths_m[result.stock_ids[slot]]
        under[slot] = _sections(line, mine[at], position_m, length_m)
        for one, other in combinations(sorted(under), 2):
            if slot in (one, other):
                pair = f"{result.stock_ids[one]} {result.stock_ids[other]}"
                found |= dict.fromkeys((section, pair) for section in sorted(under[one] & under[other]))
    return tuple(found)


def _when(
    result: RunResult, kind: type[Left | Unsafe], danger: Danger | None = None
) -> list[tuple[int, int]]:
    """When such an event of a train is in the journal, by step and slot."""
    slots = {stock_id: slot for slot, stock_id in enumerate(result.stock_ids)}
    return [
        (round(entry.t_s * STEPS_PER_S), slots[entry.event.unit_id])
        for entry in result.journal.entries
        if isinstance(entry.event, kind) and getattr(entry.event, "danger", None) is danger
    ]


def _sections(line: Line, span: TraceSpan, front_m: float, length_m: float) -> frozenset[str]:
    ends_m = (*span.starts_m[1:], float("inf"))
    return frozenset(
        line.pieces[piece].section_id
        for piece, start_m, end_m in zip(span.piece_ids, span.starts_m, ends_m, strict=True)
        if start_m < front_m and end_m > front_m - length_m
    )


def table() -> Iterator[str]:
    """A row for each step, a column for each day; the first row leaves nothing out."""
    days = {label: load_scenario(find_drill(name)) for label, name in DAYS.items()}
    yield "| left out | " + " | ".join(days) + " |"
    yield "|---|" + "---|" * len(days)
    cases: list[WorkingStep | None] = [None, *(row.step for row in PROCEDURES[Regime.TELEPHONE])]
    for case in cases:
        steps = () if case is None else (LeftOutStep(step=case),)
        cells = [outcome_of(without(day, *steps)).words for day in days.values()]
        row = f"| {'nothing' if case is None else f'`{case.value}`'} | " + " | ".join(cells) + " |"
        sys.stderr.write(row + "\n")
        yield row


def main(root: Path = Path()) -> None:
    """Write the table into its page."""
    page = root / FILE
    text = page.read_text("utf-8")
    head, _, rest = text.partition(BEGIN_MARK)
    _, _, tail = rest.partition(END_MARK)
    page.write_text(head + BEGIN_MARK + "\n".join(table()) + "\n" + END_MARK + tail, "utf-8")


if __name__ == "__main__":
    main()
