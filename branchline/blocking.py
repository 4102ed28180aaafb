"""`branchline blocking`: for how long each section is a train's, and what that time goes into; run, theory, or both."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from branchline.ending import end, judged_outcome, print_json
from branchline.options import Json, written_last
from branchline.progress import print_aside

if TYPE_CHECKING:
    from study.capacity.compared import Compared
    from study.capacity.occupation import Occupation

NUMBER_WIDTH = 9
SHORT: Final = {"change of ends": "ends", "release rule": "rule"}


def blocking(
    source: Annotated[
        str, typer.Argument(help="A shipped scenario, a scenario file (.toml), or a run directory.")
    ],
    theory: Annotated[
        bool,
        typer.Option(
            "--theory", help="Compute from running times, without a run; for a run directory both, compared."
        ),
    ] = False,
    out: Annotated[Path | None, written_last("--out", "Write the table as CSV to this file.")] = None,
    as_json: Json = False,
) -> None:
    """Show blocking times (閉そく占有時分) by train and section, what they consist of, and conflicts.

    A scenario is run; with --theory it is not. A run directory is read back.
    """
    from branchline.sources import loaded_source, occupations_as_run, setup_of_source
    from network.files.json_input import write_bytes_aside
    from study.capacity.compared import theory_and_run
    from study.capacity.occupation import conflicts_of
    from study.capacity.table import blocking_times, conflict_rows
    from study.capacity.theory import occupations
    from study.plot.write import csv_of
    from study.record.read_back import RunRead

    loaded = loaded_source(source)
    run_there = isinstance(loaded, RunRead)
    as_run = occupations_as_run(loaded, shown=True) if run_there or not theory else None
    planned = occupations(setup_of_source(loaded)) if theory else None
    shown = planned if planned is not None else as_run or ()
    both = theory_and_run(planned, as_run) if planned is not None and as_run is not None else None
    table, conflicts = blocking_times(shown), conflicts_of(shown)
    if out is not None:
        write_bytes_aside(out, csv_of(table))
        print_aside(f"wrote {out}")
    if as_json:
        found = {"of": "theory" if theory else "run", "occupations": table.to_dicts()}
        found |= {"conflicts": conflict_rows(conflicts)}
        print_json(found | ({} if both is None else {"compared": _as_dict(both)}))
    else:
        _print(shown)
        _print_conflicts(shown)
        if both is not None:
            _print_compared(both)
    # what does not fit a plan is a finding, in a run it cannot be
    end(judged_outcome(theory or not conflicts))


def _print(occupations: Sequence[Occupation]) -> None:
    """A block a train, a row a section: the parts that any has, the whole, and the costs, s."""
    from itertools import groupby

    from study.capacity.occupation import OccupationCost, OccupationPart
    from study.report.style import clock

    parts = [part for part in OccupationPart if any(one.of_part(part) > 0.0 for one in occupations)]
    costs = [cost for cost in OccupationCost if any(one.costs_s()[cost] > 0.0 for one in occupations)]
    width = max((len(one.section_id) for one in occupations), default=7)
    heads = [
        "begin",
        "end",
        *(_short(part.value) for part in parts),
        "whole",
        *(_short(cost.value) for cost in costs),
    ]
    ordered = sorted(
        occupations, key=lambda one: (_first_s(occupations, one.number), one.number, one.begin_s)
    )
    for number, own in groupby(ordered, key=lambda one: one.number):
        lines = [f"{number:{width}}" + "".join(f"{head:>{NUMBER_WIDTH}}" for head in heads)]
        for one in own:
            cells = [
                clock(one.begin_s),
                clock(one.end_s),
                *(_number(one.of_part(part)) for part in parts),
                _number(one.length_s),
                *(_number(one.costs_s()[cost]) for cost in costs),
            ]
            lines.append(f"{one.section_id:{width}}" + "".join(f"{cell:>{NUMBER_WIDTH}}" for cell in cells))
        sys.stdout.write("\n".join((*lines, "", "")))


def _first_s(occupations: Sequence[Occupation], number: str) -> float:
    return min(one.begin_s for one in occupations if one.number == number)


def _short(name: str) -> str:
    return SHORT.get(name, name[: NUMBER_WIDTH - 1])


def _number(value_s: float) -> str:
    return f"{value_s:.1f}" if value_s > 0.0 else "-"


def _print_conflicts(occupations: Sequence[Occupation]) -> None:
    from study.capacity.occupation import conflicts_of
    from study.report.style import clock

    conflicts = conflicts_of(occupations)
    sys.stdout.write(f"{len(conflicts)} conflicts\n")
    for one in conflicts:
        sys.stdout.write(
            f"{one.section_id}: {one.second.number} wants it at {clock(one.second.begin_s)}, {one.first.number} has it"
            f" until {clock(one.first.end_s)}: {one.overlap_s:.0f} s too long\n"
        )


def _as_dict(both: Compared) -> dict[str, object]:
    mean_s, worst_s = both.whole_s()
    return {
        "pairs": sum(pair.usable for pair in both.pairs),
        "only_theory": len(both.only_theory),
        "only_run": len(both.only_run),
        "whole_mean_s": mean_s,
        "whole_worst_s": worst_s,
        "parts": [one.as_dict() for one in both.differences()],
    }


def _print_compared(both: Compared) -> None:
    """Theory beside the run, a row a part."""
    mean_s, worst_s = both.whole_s()
    sys.stdout.write(
        f"\nrun less theory, {sum(pair.usable for pair in both.pairs)} occupations in both,"
        f" {len(both.only_theory)} in theory alone, {len(both.only_run)} in the run alone;"
        f" whole: mean {mean_s:+.1f} s, greatest {worst_s:+.1f} s\n"
    )
    heads = ("theory", "run", "mean", "greatest")
    sys.stdout.write(f"{'part':15}" + "".join(f"{head:>10}" for head in heads) + "  where, and why\n")
    for one in both.differences():
        cells = (f"{one.theory_s:.2f}", f"{one.run_s:.2f}", f"{one.mean_s:+.2f}", f"{one.worst_s:+.2f}")
        row = f"{one.part.value:15}" + "".join(f"{cell:>10}" for cell in cells)
        sys.stdout.write(f"{row}  {one.number} in {one.section_id}: {one.why}\n")
