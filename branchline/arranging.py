"""`branchline arrange`: the nearest workable plan to a published timetable."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from branchline.ending import end, end_with, judged_outcome, print_json
from branchline.options import Json
from branchline.progress import going_on, print_aside

if TYPE_CHECKING:
    from plan.arranging.arrange import ArrangedDay
    from plan.arranging.problem import PrintedMove

NOTHING_SHARE: Final = 0.95  # who may be so far from the least has no bound worth telling
NAMED: Final = 20  # moves that are named, the furthest first; --json has all


def arrange(
    line: Annotated[str, typer.Argument(help="A shipped line, or a line file (.toml).")],
    timetable: Annotated[str, typer.Argument(help="A shipped timetable, or a timetable file (.toml).")],
    out: Annotated[
        Path | None, typer.Argument(help="Timetable file (TOML) to write; without it nothing is written.")
    ] = None,
    train: Annotated[
        str, typer.Option("--train", help="A shipped train, or a train file (.toml).")
    ] = "br642",
    scenario: Annotated[
        Path | None, typer.Option("--scenario", help="Also write a scenario that runs it.")
    ] = None,
    limit: Annotated[
        int, typer.Option("--limit", min=0, max=14_400, help="By how much a printed time may be moved, s.")
    ] = 300,
    as_json: Json = False,
) -> None:
    """Make a published timetable work: arrivals, meets, tracks and sets, with printed times moved least.

    Exit code 1 if there is no plan, or a printed time has to be moved by more than --limit; it then says the least
    that would be enough.
    """
    from plan.arranging.arrange import NoPlanError
    from plan.arranging.arrange import arrange as arranged_by_name
    from plan.arranging.files import checked_files, write_day

    checked_files(out, scenario)
    try:
        day = arranged_by_name(line, timetable, train, limit, going_on)
    except NoPlanError as none:
        lines = filter(None, (none.would_do, none.why))
        end_with(none.as_dict(), lines, good=False, as_json=as_json)
    for path in write_day(day, line, train, out, scenario):
        print_aside(f"wrote {path}")
    outcome = judged_outcome(not day.beyond)
    if as_json:
        print_json(day.as_dict(), outcome)
    else:
        _print(day, limit)
    end(outcome)


def _print(day: ArrangedDay, limit_s: int) -> None:
    from network.clock import clock
    from plan.arranging.arrange import lacking_text

    rows = [day.text]
    if day.beyond:
        none = "no plan" if day.arranged.proven or day.none_within_s >= limit_s else "no plan that was found"
        would = "least that would do" if day.arranged.proven else "best that was found"
        rows.insert(0, f"{none} moves every printed time by {limit_s} s or less; the {would}:")
        rows[1:1] = list(_named(day, day.beyond, "  "))
        if day.lacking is not None:
            rows.insert(0, lacking_text(day.line, day.lacking))
    rows += _named(day, [move for move in day.moves if abs(move.by_s) <= limit_s], "moved: ")
    stops = [f"{number} at {clock(at_s)[:-3]}" for number, _, at_s in day.added]
    by_station: dict[str, list[str]] = {}
    for (_, station_id, _), text in zip(day.added, stops, strict=True):
        by_station.setdefault(station_id, []).append(text)
    rows += [
        f"stops added: {day.line.stations[s].name}: {', '.join(texts)}" for s, texts in by_station.items()
    ]
    for number in day.empty:
        calls = day.timetable.trains[number].calls
        way = " - ".join(day.line.stations[calls[at].station_id].name for at in (0, -1))
        rows.append(f"empty working added: {number}, {way} at {clock(calls[0].last_s)[:-3]}")
    furthest_s = max((abs(move.by_s) for move in day.moves), default=0)
    searched = f"of plans that move no time by more than {day.arranged.reach_s} s, the bound of the search"
    rows.append(f"{_proof(day, limit_s)}, {searched}; this one moves none by more than {furthest_s} s")
    if day.beyond and day.none_within_s:
        rows.append(f"proven: no plan moves every printed time by {day.none_within_s} s or less")
    sys.stdout.write("\n".join(rows) + "\n")


def _proof(day: ArrangedDay, limit_s: int) -> str:
    """How far the plan is from the least, at most."""
    if day.arranged.proven:
        few = ", by other tracks only beside trains that are there by print" if day.by_print else ""
        return f"the least that there is{few}"
    gap_s, share = day.gap
    if not day.beyond:
        return f"the best that was found, at most {math.ceil(gap_s)} s from the least"
    if share > NOTHING_SHARE:
        return "the best that was found; how much less would do is not known"
    return (
        f"the best that was found, at most {math.ceil(100.0 * share)} % from the least, a second beyond {limit_s} s"
        " counting a thousandfold"
    )


def _named(day: ArrangedDay, moves: Sequence[PrintedMove], mark: str) -> Iterator[str]:
    """The furthest moves, and how many there are besides."""
    worst = sorted(moves, key=lambda move: (-abs(move.by_s), move.number, move.printed_s))
    yield from (f"{mark}{_move(day, move)}" for move in worst[:NAMED])
    if len(worst) > NAMED:
        yield f"{mark}{len(worst) - NAMED} more, by {abs(worst[NAMED].by_s)} s at most"


def _move(day: ArrangedDay, move: PrintedMove) -> str:
    from network.clock import clock

    name = day.line.stations[move.station_id].name
    return f"{move.number} {move.by_s:+d} s at {name} ({move.what} printed {clock(move.printed_s)[:-3]})"
