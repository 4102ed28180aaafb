"""`branchline best interval`: the least interval of a line, proven, and a timetable at it that runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from branchline.ending import end_with
from branchline.extras import needing_extra
from branchline.options import Json, ScenarioName, written_last
from branchline.progress import print_aside

if TYPE_CHECKING:
    from network.timetable import Timetable
    from plan.least_interval import LeastInterval, RepeatedPaths
    from plan.moving.proof import Circle, Impossibility
    from simulation.setup import Setup

SetLate = Annotated[
    bool,
    typer.Option("--set-late", help="Set routes as late as trains still run unhindered, not when units ask."),
]
ScenarioOut = Annotated[
    Path | None, typer.Option("--out", help="Scenario file (TOML) to write that runs the answer all day.")
]


def interval(
    scenario: ScenarioName,
    set_late: SetLate = False,
    out: ScenarioOut = None,
    proof: Annotated[
        Path | None, written_last("--proof", "Where the proof that no less does is written (JSON).")
    ] = None,
    check: Annotated[
        Path | None,
        typer.Option(
            "--check",
            help="Without --out or --proof: only check this proof against the line's own times; search nothing.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Find the least interval at which a line takes a train each way, and prove that no second less does.

    Trains run as they are driven, on the timetable's tracks, stop for the least time allowed and wait where they
    stop and a set can stand. Sets that run to and fro all day may use two tracks of a terminus alternately, if that is
    quicker. All times are whole seconds.
    """
    from network.files.json_input import read_json, write_aside
    from scenario.scenario import load_scenario

    with needing_extra("plan", "interval"):
        from plan.least_interval import AS_UNITS_ASK, SET_LATE, least_of_tracks, recounted
    from plan.moving.proof import Impossibility, proof_text

    if out is not None:
        new_day(out, scenario)
    setup = load_scenario(scenario).setup
    rules = SET_LATE if set_late else AS_UNITS_ASK
    if check is not None:
        wrong = recounted(setup, rules, asked := read_json(check, Impossibility))
        right = f"right: by the line's own times no interval of {_ranges(asked)} fits"
        end_with({"objections": wrong}, wrong or [right], good=not wrong, as_json=as_json)
    found = least_of_tracks(setup, rules)
    if proof is not None:
        write_aside(proof, proof_text(found.proof))
    if out is not None:
        write_answer(out, setup, found, scenario)
    end_with(figures_of(found), _rows(found), good=found.interval_s is not None, as_json=as_json)


def figures_of(found: LeastInterval) -> dict[str, Any]:
    """For JSON."""
    return {
        "interval_s": found.interval_s,
        "trains_each_way": found.pattern.trains_each_way,
        "waits_s": found.waits_s if found.interval_s else None,
        "least_waits": found.least_waits,
        "excluded_s": [[one.from_ticks, one.to_ticks] for one in found.proof.excluded],
        "circles": [len(circles) for circles in found.circles()],
        "in_tenths_s": found.in_tenths_s,
        "one_circle_excludes_s": None if found.circle is None else found.circle[1],
    }


def write_answer(
    out: Path, setup: Setup, found: LeastInterval, extends: str, changes: Mapping[str, Any] | None = None
) -> None:
    """A scenario that runs a line at its least interval all day, and its timetable beside it."""
    if found.interval_s is not None:
        write_day_of(out, setup, found.pattern, found.moves_s, found.interval_s, extends, changes)


def write_day_of(
    out: Path,
    setup: Setup,
    pattern: RepeatedPaths,
    moves_s: Sequence[Sequence[float]],
    every_s: int,
    extends: str,
    changes: Mapping[str, Any] | None = None,
) -> None:
    """A scenario that repeats a pattern all day. Raises InputError where one of its files stands already."""
    from plan.even_day import Repetition, timetable_of

    day = timetable_of(setup, Repetition(pattern, moves_s, every_s), times_beside(out).stem)
    write_extending(out, day, extends, changes)


def write_extending(
    out: Path, timetable: Timetable, extends: str, changes: Mapping[str, Any] | None = None
) -> None:
    """A scenario with another timetable, and what else is changed. InputError where one of its files stands already."""
    from plan.even_day import write_day

    write_day(out, timetable, new_day(out, extends), changes or {})
    print_aside(f"wrote {out} and {timetable.head.id}.toml beside it")


def new_day(out: Path, extends: str) -> str:
    """How the scenario to be written names the one that it extends. InputError where a file of it stands already."""
    from study.making.place import checked_new, extended_by

    base = extended_by(out, extends, "--out")
    checked_new(times_beside(out), "--out")
    return base


def times_beside(out: Path) -> Path:
    """Where its timetable goes."""
    return out.with_name(f"{out.stem}_times.toml")


def _times(circle: Circle) -> str:
    count = sum(bound.periods for bound in circle.bounds)
    return "" if count == 1 else f"{count} times "


def _rows(found: LeastInterval) -> list[str]:
    from plan.moving.stints import stints_of

    if found.interval_s is None:
        rows = [f"none: no interval of {_ranges(found.proof)} fits"]
    else:
        surely = "least that it can be" if found.least_waits else "perhaps more than it need be"
        trains, each_s = found.pattern.trains_each_way, found.each_s
        of = "" if trains == 1 else f" of {trains} trains each way, on tracks that they take by turns"
        rows = [
            f"least interval{of} {found.interval_s} s ({found.interval_s / 60:.1f} min),"
            f" {3600 / each_s:.2f} trains an hour each way",
            f"waits: {found.waits_s:.0f} s of all trains together, {surely}",
            f"in tenths of a second, which no timetable has: {found.in_tenths_s:.1f} s",
            f"excluded: every whole second of {_ranges(found.proof)}",
        ]
    cases = sum(len(circles) for circles in found.circles())
    if cases > 1:
        rows.append(f"in {cases} cases, each of which ends in a circle of trains (--proof writes them)")
    if found.circle is not None:
        circle, to_s = found.circle
        rows.append(f"one circle excludes all up to {to_s} s:")
        rows += [
            f"  {one.direction.name.lower()} train: from having {one.takes} until {one.frees} is free"
            f" {one.length_s:.1f} s"
            for one in stints_of(found.pattern.all_legs, circle, found.proof.tick_s)
        ]
        together_s = sum(bound.least for bound in circle.bounds)
        rows.append(f"  in whole seconds {together_s} s, which is more than {_times(circle)}{to_s} s")
    return rows


def _ranges(proof: Impossibility) -> str:
    """The periods that a proof excludes, in words."""
    return " and ".join(
        f"{max(one.from_ticks, 1)} s and more"
        if one.to_ticks is None
        else f"{max(one.from_ticks, 1)} to {one.to_ticks} s"
        for one in proof.excluded
    )
