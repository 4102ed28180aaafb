"""`branchline import gtfs` and `branchline export gtfs`."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from branchline import options
from branchline.importing_timetables import (
    OUTSIDE_MIN_S,
    TURN_MIN_S,
    ImportOptions,
    say_written,
    write_or_count,
    write_read_back,
)
from branchline.oudia import timetables_of
from branchline.progress import print_aside

if TYPE_CHECKING:
    from exchange.gtfs.reader import GtfsDay
    from exchange.gtfs.writer import FeedFacts

# As `exchange.gtfs.writer` has them, which is not imported for `--help`.
_URL: Final = "https://example.com/"
_TIMEZONE: Final = "Asia/Tokyo"
_FIRST, _LAST = "20260101", "20261231"
_EVERY_DAY: Final = "1111111"
_CENTRE: Final = "35,135"


def import_gtfs(
    source: Annotated[Path, typer.Argument(help="A GTFS feed: a zip archive, or a folder with its tables.")],
    out: options.TimetableOut = None,
    line: options.LineName = None,
    date: Annotated[str, typer.Option("--date", help="The day, YYYY-MM-DD.")] = "",
    service: Annotated[
        str, typer.Option("--service", help="A service id of the feed instead of a day.")
    ] = "",
    route: Annotated[
        list[str] | None,
        typer.Option("--route", help="A route by id or short name, may be repeated; default all by rail."),
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
    """Read one day of a GTFS feed and, with --line, write its timetable file."""
    from exchange.gtfs.reader import GtfsChoice, read_gtfs

    day = read_gtfs(source, GtfsChoice(date, service, tuple(route or ())))
    plain = not (date or service or route or name or names or add or train or without)
    if line is not None and plain and _read_back(day, line, timetable_id, out, as_json=as_json):
        return
    suffix = date.replace("-", "") or service or "day"
    credit = f"numbers and times: GTFS feed {source.name}"
    wanted = ImportOptions(
        credit,
        suffix,
        line,
        out,
        timetable_id,
        name or (),
        names,
        add,
        turn_min,
        outside_min,
        in_order=False,
        train=train,
        without=without or (),
    )
    counts = {"feed_trips": day.trips, "feed_stops": day.stops, "feed_calls": day.calls}
    write_or_count(day.published, wanted, counts, as_json=as_json)


def export_gtfs(
    source: Annotated[
        str, typer.Argument(help="A run directory, a shipped scenario, or a scenario file (.toml).")
    ],
    out: Annotated[Path, typer.Argument(help="Archive to write (.zip).")],
    agency: Annotated[str, typer.Option("--agency", help="Name of the operator; default the line's.")] = "",
    url: Annotated[str, typer.Option("--agency-url", help="Web address of the operator.")] = _URL,
    timezone: Annotated[str, typer.Option("--timezone", help="Time zone of the timetable.")] = _TIMEZONE,
    first: Annotated[str, typer.Option("--from", help="First day, YYYYMMDD.")] = _FIRST,
    last: Annotated[str, typer.Option("--to", help="Last day, YYYYMMDD.")] = _LAST,
    weekdays: Annotated[
        str, typer.Option("--weekdays", help="Days of service from Monday: seven digits 0 or 1.")
    ] = _EVERY_DAY,
    centre: Annotated[
        str,
        typer.Option("--centre", help="LATITUDE,LONGITUDE of the origin of the line's plane coordinates."),
    ] = _CENTRE,
    as_json: options.Json = False,
) -> None:
    """Write a timetable as a GTFS feed; of a run directory, the day as it was run."""
    from exchange.gtfs.writer import write_gtfs
    from network.errors import COMMAND_LINE, InputError

    facts = _facts(agency, url, timezone, (first, last), weekdays, centre)
    line, timetable, as_run = timetables_of(source)
    if as_run is not None:
        if not as_run:
            raise InputError(COMMAND_LINE, "SOURCE", source, "a run in which a train ran")
        timetable = replace(timetable, trains={train.number: train for train in as_run})
    rows = write_gtfs(out, line, timetable, facts)
    if centre == _CENTRE:
        print_aside(f"places of stations are about {_CENTRE} degrees; --centre says where the line really is")
    say_written({"line": line.id, "timetable": timetable.head.id, **rows}, out, as_json=as_json)


def _facts(
    agency: str, url: str, timezone: str, dates: tuple[str, str], weekdays: str, centre: str
) -> FeedFacts:
    from exchange.gtfs.days import date_of
    from exchange.gtfs.writer import FeedFacts
    from network.errors import COMMAND_LINE, InputError
    from network.files.names import TITLE_HELP, title_of

    for option, text in (("--agency", agency), ("--agency-url", url), ("--timezone", timezone)):
        if title_of(text) != text:
            raise InputError(COMMAND_LINE, option, text, TITLE_HELP)
    if not re.fullmatch(r"https?://\S+", url):
        raise InputError(COMMAND_LINE, "--agency-url", url, "an address that begins with http:// or https://")
    if not re.fullmatch(r"[A-Z][A-Za-z_]*(?:/[A-Za-z0-9_+-]+)*", timezone):
        raise InputError(
            COMMAND_LINE, "--timezone", timezone, "a name of the tz database, such as Asia/Tokyo"
        )
    if not re.fullmatch("[01]{7}", weekdays) or "1" not in weekdays:
        raise InputError(
            COMMAND_LINE, "--weekdays", weekdays, "seven of 0 and 1 from Monday, such as 1111100"
        )
    first, last = (
        date_of(COMMAND_LINE, option, text) for option, text in zip(("--from", "--to"), dates, strict=True)
    )
    if last < first:
        raise InputError(COMMAND_LINE, "--to", dates[1], f"a day not before {dates[0]}")
    match = re.fullmatch(r"(-?\d{1,2}(?:\.\d+)?),(-?\d{1,3}(?:\.\d+)?)", centre)
    place = (float(match[1]), float(match[2])) if match else (90.0, 0.0)
    if abs(place[0]) > 84 or abs(place[1]) > 180:
        expected = "LATITUDE,LONGITUDE in degrees, latitude at most 84, such as 36.6491,140.067"
        raise InputError(COMMAND_LINE, "--centre", centre, expected)
    return FeedFacts(agency, url, timezone, first, last, weekdays, place)


def _read_back(
    day: GtfsDay, line_name: str, timetable_id: str | None, out: Path | None, *, as_json: bool
) -> bool:
    """Whether the feed is one of ours and whole; then it is read back as it was written."""
    from exchange.gtfs.exact import read_back
    from network.files.line_file import load_line
    from network.files.shipped import shipped_line

    if day.written is None:
        return False
    line = load_line(shipped_line(line_name))
    file, why = read_back(day.written, line, day.published.source)
    if file is None:
        print_aside(f"read as any other feed: {why}")
        return False
    write_read_back(file, timetable_id, out, {}, as_json=as_json)
    return True
