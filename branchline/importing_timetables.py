"""`branchline import mini-tokyo`, `gtfs`, ...: a published timetable counted, or made into a file for a line."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, cast

import typer

from branchline import options
from branchline.ending import print_json
from branchline.progress import going_on, print_aside
from study.outcome import Outcome

if TYPE_CHECKING:
    from exchange.import_timetable import ImportedTimetable
    from exchange.published import PublishedTimetable
    from exchange.running import Running
    from network.files.timetable_schema import TimetableFile
    from network.model import Line

TURN_MIN_S: Final = 120  # as `exchange.workings` has it, which is not imported for `--help`
OUTSIDE_MIN_S: Final = 1800


@dataclass(frozen=True, slots=True)
class ImportOptions:
    """What the options of such a command say; `credit` and `suffix` (of the timetable's id) are the reader's."""

    credit: str
    suffix: str
    line: str | None
    out: Path | None
    id: str | None = None
    by_hand: Sequence[str] = ()
    by_hand_file: Path | None = None
    additions: str | None = None
    turn_min_s: int = TURN_MIN_S
    outside_min_s: int = OUTSIDE_MIN_S
    in_order: bool = True
    train: str | None = None
    without: Sequence[str] = ()


def import_mini_tokyo(
    source: Annotated[Path, typer.Argument(help="Trains of a railway in the form of mini-tokyo-3d (JSON).")],
    out: options.TimetableOut = None,
    line: options.LineName = None,
    calendar: Annotated[
        str, typer.Option("--calendar", help="Weekday, SaturdayHoliday or another calendar of the file.")
    ] = "Weekday",
    railway: Annotated[str, typer.Option("--railway", help="Which railway, if the file has several.")] = "",
    stations: Annotated[
        Path | None, typer.Option("--stations", help="The source's file of stations, for their names (JSON).")
    ] = None,
    timetable_id: options.TimetableId = None,
    name: options.ByHand = None,
    names: options.ByHandFile = None,
    add: options.Additions = None,
    train: options.RunBy = None,
    turn_min: options.TurnMin = TURN_MIN_S,
    outside_min: options.OutsideMin = OUTSIDE_MIN_S,
    without: options.Without = None,
    as_json: options.Json = False,
) -> None:
    """Read one day of a file of mini-tokyo-3d and, with --line, write its timetable file."""
    from exchange.mini_tokyo import SOURCE, read_mini_tokyo

    published = read_mini_tokyo(source, calendar, stations, railway)
    suffix = {"Weekday": "weekday", "SaturdayHoliday": "holiday"}.get(calendar, calendar)
    wanted = ImportOptions(
        SOURCE,
        suffix,
        line,
        out,
        timetable_id,
        name or (),
        names,
        add,
        turn_min,
        outside_min,
        train=train,
        without=without or (),
    )
    write_or_count(published, wanted, as_json=as_json)


def write_or_count(
    published: PublishedTimetable,
    wanted: ImportOptions,
    counts: dict[str, Any] | None = None,
    *,
    as_json: bool,
) -> None:
    """Count a published timetable, or put it on the line that is wanted and write the file; say what came of it.

    `counts` are figures of the reader's own, shown first.
    """
    from network.errors import COMMAND_LINE, InputError

    if wanted.line is None and wanted.out is not None:
        raise InputError(COMMAND_LINE, "--line", None, "the line of the timetable file that is to be written")
    figures = {**(counts or {}), **timetable_counts(published)} if wanted.line is None else {}
    if wanted.line is not None:
        imported, line = _imported(published, wanted)
        said: dict[str, list[str]] = {"arranged": []}
        if wanted.train is not None and imported.departures_alone:
            imported, said["arranged"] = _arranged(imported, line, wanted)
        figures = {**(counts or {}), **imported.figures(), **said}
        if wanted.out is not None:
            from exchange.import_timetable import write_timetable

            write_timetable(imported, wanted.out)
    say_written(figures, wanted.out, as_json=as_json)


def write_read_back(
    file: TimetableFile, timetable_id: str | None, out: Path | None, about: dict[str, str], *, as_json: bool
) -> None:
    """Write a timetable that is read back as branchline wrote it, and say what it holds and what the reader adds."""
    from exchange.timetable_writer import timetable_toml
    from network.files.json_input import write_aside

    head = file.timetable
    if timetable_id is not None:
        head = head.model_copy(update={"id": _identifier(timetable_id)})
        file = file.model_copy(update={"timetable": head})
    if out is not None:
        write_aside(out, timetable_toml(file))
    figures: dict[str, Any] = {
        "timetable": head.id,
        "line": head.line,
        **about,
        "trains": len(file.trains),
        "calls": sum(len(train.calls) for train in file.trains),
        "sets": len(file.diagrams),
        "read": "back, as it was written by branchline",
    }
    say_written(figures, out, as_json=as_json)


def say_written(figures: dict[str, Any], out: Path | None, *, as_json: bool) -> None:
    """Figures as they are asked for, and the file that was written."""
    if as_json:
        print_json(figures, Outcome.GOOD)
    else:
        print_figures(figures)
    if out is not None:
        print_aside(f"wrote {out}")


def _identifier(timetable_id: str) -> str:
    from network.errors import COMMAND_LINE, InputError
    from network.files.names import IDENTIFIER_HELP, is_identifier

    if not is_identifier(timetable_id):
        raise InputError(COMMAND_LINE, "--id", timetable_id, IDENTIFIER_HELP)
    return timetable_id


def timetable_counts(published: PublishedTimetable) -> dict[str, Any]:
    """What a published timetable holds, without a line."""
    return {
        "name": published.name,
        "trains": len(published.trains),
        "stations": len(published.stations),
        "calls": sum(len(train.calls) for train in published.trains),
        "down": sum(train.direction == "down" for train in published.trains),
        "up": sum(train.direction == "up" for train in published.trains),
        "linked": sum(bool(train.follows or train.becomes or train.working) for train in published.trains),
        "beyond": sum(bool(train.comes_from or train.goes_to) for train in published.trains),
        "station_names": [station.name or station.name_ja or station.key for station in published.stations],
        "left": list(published.left),
    }


def _imported(published: PublishedTimetable, wanted: ImportOptions) -> tuple[ImportedTimetable, Line]:
    """The timetable on its line, and the line."""
    from exchange import additions
    from exchange.import_timetable import ImportOrder, import_timetable
    from exchange.station_join import names_by_hand
    from exchange.workings import SetRules
    from network.errors import COMMAND_LINE
    from network.files.line_file import load_line
    from network.files.shipped import shipped_line

    line = load_line(shipped_line(wanted.line or ""))
    timetable_id = _identifier(wanted.id or f"{line.id}_{wanted.suffix}")
    added = additions.Additions()
    if wanted.additions is not None:
        added = additions.read_additions(additions.shipped_additions(wanted.additions), line)
    least, least_of = (None, "") if wanted.train is None else _least(line, wanted.train)
    order = ImportOrder(
        id=timetable_id,
        credit=wanted.credit,
        rules=SetRules(wanted.turn_min_s, wanted.outside_min_s),
        additions=added,
        by_hand=names_by_hand(wanted.by_hand, wanted.by_hand_file),
        hand_file=COMMAND_LINE if wanted.by_hand_file is None else str(wanted.by_hand_file),
        in_order=wanted.in_order,
        without=tuple(dict.fromkeys(wanted.without)),
        least=least,
        least_of=least_of,
    )
    return import_timetable(published, line, order), line


def _arranged(
    imported: ImportedTimetable, line: Line, wanted: ImportOptions
) -> tuple[ImportedTimetable, list[str]]:
    """The nearest plan that works, and what it moves; as it is where no plan keeps the usual limit, and why.

    With the command that does it all the same of the file that is written.
    """
    from branchline.extras import needing_extra
    from network.errors import InputError

    name = imported.timetable.head.id
    train_name = wanted.train or ""
    try:
        with needing_extra("plan", "--train"):
            from plan.arranging.arrange import LIMIT_S, NoPlanError, arranged_day
        from vehicle.train_file import load_train, train_named

        train = load_train(train_named(train_name))
        try:
            day = arranged_day(line, imported.file, name, train, LIMIT_S, tell=going_on)
        except NoPlanError as why:
            return imported, [f"not: {why}"]
    except InputError as why:
        return imported, [f"not, as of the source alone no plan is found: {why}"]
    if day.beyond:
        worst_s = max(abs(move.by_s) for move in day.beyond)
        command = (
            "arrange",
            str(wanted.line),
            str(wanted.out),
            "--train",
            train_name,
            "--limit",
            str(worst_s),
        )
        how = "" if wanted.out is None else f": branchline {shlex.join(command)}"
        return imported, [f"not, as the least that would do moves a printed time by {worst_s} s{how}"]
    return imported.arranged(day.file, day.timetable), [day.text]


def _least(line: Line, train_name: str) -> tuple[Running, str]:
    """Least running times of a train by leg, and its id."""
    from study.measures.standard_times import least_by_leg
    from vehicle.train_file import load_train, train_named

    train = load_train(train_named(train_name))
    return least_by_leg(line, train), train.id


def print_figures(figures: dict[str, Any]) -> None:
    """Counts as `key: value`, lists a line each, the table of stations with what joined each."""
    from network.raw import is_list

    for key, value in figures.items():
        if not is_list(value):
            sys.stdout.write(f"{key}: {value}\n")
        elif key == "station_names":
            sys.stdout.write(f"{key}: {', '.join(map(str, value))}\n")
        elif key == "stations":
            for row in cast("list[dict[str, Any]]", value):
                like = f"; like {', '.join(row['like'])}" if row["like"] else ""
                sys.stdout.write(f"station: {row['source']} = {row['station'] or '-'} ({row['by']}{like})\n")
        else:
            for text in value:
                sys.stdout.write(f"{key.removesuffix('s')}: {text}\n")
