"""What the study of the order of trains keeps of its days, and the table that follows from it.

`python -m documents.order_of_trains blocks SEED DAYS` plays late days of the busy line by the manager alone, by each
rule; `python -m documents.order_of_trains runs SWEEP` takes days run whole from the directory of the study's sweep.
Both write what each rule lost on each day into docs/studies/order_of_trains; `documents.studies` makes the table.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from types import MappingProxyType
from typing import Final

from study.evaluate.order_of_trains import SAID, days_lost_min
from study.sweep.plan import load_plan
from study.sweep.statistics import FigureEstimate, difference_of, mean_of
from study.sweep.store import day_name, filed_day
from wayside.config import OrderRule

FOLDER: Final = Path(__file__).resolve().parents[1] / "docs" / "studies" / "order_of_trains"
SCENARIO: Final = "busy_line"
SWEEP: Final = FOLDER / "late_mornings_sweep.toml"
RULES: Final = (OrderRule.FIRST_COME, OrderRule.LEAST_DELAY)
PLAYED: Final = MappingProxyType(
    {"blocks": "96 trains, in blocks and minutes", "runs": "32 trains, run whole"}
)
SAME_MIN: Final = 1e-6


@dataclass(frozen=True, slots=True)
class OrderedDay:
    """Train-minutes that each of two rules lost on one day."""

    seed: int
    first_come_min: float
    least_delay_min: float

    @property
    def pair(self) -> tuple[float, float]:
        """As a difference is made of it: who asks first, then least delay."""
        return self.first_come_min, self.least_delay_min


def kept_days(name: str) -> tuple[OrderedDay, ...]:
    """The days that are kept, played in one of the ways of PLAYED."""
    rows = csv.reader(StringIO((FOLDER / f"{name}.csv").read_text("utf-8")))
    next(rows)
    return tuple(OrderedDay(int(seed), float(first), float(least)) for seed, first, least in rows)


def csv_text(days: Sequence[OrderedDay]) -> str:
    """The file of kept days."""
    lines = [f"{day.seed},{day.first_come_min:.1f},{day.least_delay_min:.1f}\n" for day in days]
    return "seed,first_come_min,least_delay_min\n" + "".join(lines)


def less_lost(days: Sequence[OrderedDay]) -> FigureEstimate:
    """By how much least delay loses more a day than who asks first, min, day by day."""
    return difference_of([day.pair for day in days], SAID)


def verdict(found: FigureEstimate) -> str:
    """Whether an order helps, by the interval of what it loses more."""
    if not found.apart_from_0 or found.value is None:
        return "not shown"
    return "loses less" if found.value < 0.0 else "loses more"


def table() -> Iterator[str]:
    """What each rule loses a day, and the difference, day by day."""
    head = (
        "played",
        "days",
        "lost, who asks first, min",
        "by least delay, min",
        "more, min",
        "better, same, worse",
    )
    yield f"| {' | '.join(head)} | least delay |"
    yield "|---|---|---|---|---|---|---|"
    for name, stated in PLAYED.items():
        days = kept_days(name)
        first, least = zip(*(day.pair for day in days), strict=True)
        more = less_lost(days)
        apart = [after - before for before, after in (day.pair for day in days)]
        better, worse = sum(s < -SAME_MIN for s in apart), sum(s > SAME_MIN for s in apart)
        counts = f"{better}, {len(days) - better - worse}, {worse}"
        lost = " | ".join(mean_of(each, SAID).text for each in (first, least))
        yield f"| {stated} | {len(days)} | {lost} | {more.text} | {counts} | {verdict(more)} |"


def played(seeds: Sequence[int]) -> Iterator[OrderedDay]:
    """Days played by the manager alone."""
    lost_min = (days_lost_min(SCENARIO, order, seeds) for order in RULES)
    yield from (OrderedDay(*each) for each in zip(seeds, *lost_min, strict=True))


def swept(out: Path) -> Iterator[OrderedDay]:
    """Days of the study's sweep, as far as both rules have been run."""
    plan = load_plan(str(SWEEP))
    for index in range(plan.days):
        records = [filed_day(out, day_name(plan.spec(point, index), index)) for point in plan.points]
        figures = [None if record is None else record.figures for record in records]
        first, least = figures
        if first is None or least is None:
            return
        seed = plan.spec(plan.points[0], index).seed
        yield OrderedDay(seed, first.lost_train_minutes, least.lost_train_minutes)


def main(arguments: Sequence[str]) -> None:
    """Keep days: `blocks SEED DAYS`, or `runs SWEEP`."""
    name, first, *more = arguments
    days = swept(Path(first))
    if name == "blocks":
        days = played(range(int(first), int(first) + int(more[0])))
    (FOLDER / f"{name}.csv").write_text(csv_text(tuple(days)), "utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
