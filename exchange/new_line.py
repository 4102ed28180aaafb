"""`branchline new line`: a whole line file from a list of its stations, and whatever is known beside it.

The list says which stations there are and how many tracks each has; `network.making.layout` lays out sections and
points, `network.tag_layout` the tags. Everything that neither the list nor a joined file says stands in the line
file's `assumed`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from exchange.joined import (
    StationsOnAxis,
    joined_limits,
    prolonged_axis,
    read_crossings,
    read_gradients,
    read_limits,
    with_geometry,
    without_geometry,
)
from network.errors import COMMAND_LINE, InputError
from network.files.json_input import check_free, write_aside
from network.files.line_file import parse_line
from network.files.names import IDENTIFIER_HELP, TITLE_HELP, is_identifier, title_of
from network.files.quantities import SPEED, TRAIN_LENGTH
from network.making.crossing_places import LaidCrossing, laid_crossings
from network.making.layout import STUB_SPEED_KMH, LayoutRule, LineLayout, lay_out
from network.making.line_text import DIVERGING_KMH, THROW_TIME_S, LineHeader, line_toml
from network.making.station_list import StationList, read_station_list
from network.model import Direction, Gradient, Line, SpeedLimit

MAX_SPEED_KMH: Final = 85.0
TRAIN_LENGTH_M: Final = 40.0


@dataclass(frozen=True, slots=True)
class NewLineOptions:
    """What the command line says beside the list; None where it says nothing."""

    line_id: str | None = None
    name: str | None = None
    name_ja: str | None = None
    max_speed_kmh: float | None = None
    train_length_m: float | None = None
    polyline: Path | None = None
    stations_geometry: Path | None = None
    gradients: Path | None = None
    limits: Path | None = None
    crossings: Path | None = None


@dataclass(frozen=True, slots=True)
class NewLine:
    """A line that was made: its file's text, what each station's place rests on, what is to be remarked on."""

    text: str
    line: Line
    rows: tuple[str, ...]
    remarks: tuple[str, ...]


def make_line(list_file: Path, line_id: str, options: NewLineOptions) -> NewLine:
    """Make a line; `line_id` counts where neither list nor command line names it. Raises InputError."""
    stations = read_station_list(list_file)
    max_speed_kmh, train_length_m = _figures(stations, options)
    rule = LayoutRule(train_length_m, max_speed_kmh / 3.6)
    joined = _joined(stations, options, max_speed_kmh)
    layout = lay_out(stations.file, stations.stations, joined.places_m, rule)
    listed = stations.crossings if options.crossings is None else read_crossings(options.crossings)
    crossings = tuple(laid_crossings(listed, layout, (points.terminal for points in layout.points)))
    alignment = prolonged_axis(joined.alignment, layout.from_m, layout.to_m)
    gradients: tuple[Gradient, ...] = (Gradient(alignment.from_m, alignment.to_m, 0.0),)
    remarks = joined.remarks
    if options.gradients is not None:
        gradients, more = read_gradients(options.gradients, alignment.from_m, alignment.to_m)
        remarks += more
    given: tuple[SpeedLimit, ...] = ()
    if options.limits is not None:
        given, more = read_limits(options.limits, alignment.from_m, alignment.to_m)
        remarks += more
    derived = (*joined.alignment.limits, *_stub_limits(layout, max_speed_kmh))
    alignment = replace(alignment, gradients=gradients, limits=joined_limits(derived, given))
    words = LineHeader(
        _line_id(stations, options, line_id),
        _title("--name", options.name) or stations.head.name or line_id,
        _title("--name-ja", options.name_ja) or stations.head.name_ja,
        max_speed_kmh,
        sources=(*stations.head.sources, *joined.sources, *_file_sources(options)),
        assumed=(
            *stations.head.assumed,
            *joined.assumed,
            *_assumed(stations, options, layout, rule, crossings),
        ),
        comment=(
            "Made by `branchline new line`; what it rests on stands in `sources` and `assumed`.",
            *joined.comment,
        ),
    )
    try:
        text = line_toml(words, alignment, layout, rule, crossings)
        line = parse_line(text, line_id)
    except (InputError, ValueError) as error:  # of a file that is not there: what can be changed is the list
        expected = f"stations of which a line can be laid out; of these there would be {error}"
        raise InputError(stations.file, "stations", None, expected) from error
    return NewLine(text, line, joined.rows, remarks)


def write_line(list_file: Path, out_file: Path, options: NewLineOptions) -> NewLine:
    """Make a line and write its file, whole or not at all. Raises InputError."""
    if not out_file.parent.is_dir():
        raise InputError(str(out_file), "", None, "a writable path in an existing folder")
    if out_file.suffix != ".toml":
        raise InputError(COMMAND_LINE, "OUT", str(out_file), "a name ending in .toml")
    check_free(out_file)
    new_line = make_line(list_file, out_file.stem, options)
    write_aside(out_file, new_line.text)
    return new_line


def _figures(stations: StationList, options: NewLineOptions) -> tuple[float, float]:
    """Greatest speed (km/h) and train length (m): asked, else listed, else assumed."""
    for option, value, quantity in (
        ("--max-speed", options.max_speed_kmh, SPEED),
        ("--train-length", options.train_length_m, TRAIN_LENGTH),
    ):
        if value is not None and not quantity.holds(value):
            raise InputError(COMMAND_LINE, option, value, f"{quantity.text()} ({quantity.name})")
    speed = (options.max_speed_kmh, stations.head.max_speed_kmh, MAX_SPEED_KMH)
    length = (options.train_length_m, stations.head.train_length_m, TRAIN_LENGTH_M)
    return next(v for v in speed if v is not None), next(v for v in length if v is not None)


def _joined(stations: StationList, options: NewLineOptions, max_speed_kmh: float) -> StationsOnAxis:
    if options.polyline is None and options.stations_geometry is None:
        return without_geometry(stations)
    if options.polyline is None or options.stations_geometry is None:
        missing = "--polyline" if options.polyline is None else "--stations-geometry"
        raise InputError(
            COMMAND_LINE, missing, None, "both files of the geometry, the track and its stations"
        )
    return with_geometry(stations, options.polyline, options.stations_geometry, max_speed_kmh)


def _line_id(stations: StationList, options: NewLineOptions, line_id: str) -> str:
    name = options.line_id or stations.head.id or line_id
    if not is_identifier(name):
        raise InputError(COMMAND_LINE, "--id", name, IDENTIFIER_HELP)
    return name


def _title(option: str, text: str | None) -> str:
    if text is None:
        return ""
    if title_of(text) != text:
        raise InputError(COMMAND_LINE, option, text, TITLE_HELP)
    return text


def _stub_limits(layout: LineLayout, max_speed_kmh: float) -> Iterator[SpeedLimit]:
    """Trains come slowly to where the rails end."""
    if max_speed_kmh <= STUB_SPEED_KMH:
        return
    for from_m, to_m, towards in layout.stubs:
        direction = Direction.DOWN if towards == "down" else Direction.UP
        yield SpeedLimit(from_m, to_m, STUB_SPEED_KMH / 3.6, (direction,))


def _file_sources(options: NewLineOptions) -> Iterator[str]:
    for what, file in (
        ("gradients", options.gradients),
        ("limits", options.limits),
        ("level crossings", options.crossings),
    ):
        if file is not None:
            yield f"{what}: {title_of(file.name)}"


def _assumed(
    stations: StationList,
    options: NewLineOptions,
    layout: LineLayout,
    rule: LayoutRule,
    crossings: Sequence[LaidCrossing],
) -> Iterator[str]:
    """A sentence for each figure that neither the list nor a joined file gives."""
    if options.max_speed_kmh is None and stations.head.max_speed_kmh is None:
        yield f"maximum speed: {MAX_SPEED_KMH:g} km/h, a common figure for branch lines"
    if options.polyline is not None:
        yield "limits of curves: the customary basic speeds of 1067 mm gauge, 3.7 sqrt(R) to the nearest 5 km/h"
    if layout.stubs:
        yield f"limits of stubs: {STUB_SPEED_KMH:g} km/h on the last track, towards its end"
    if options.limits is not None:
        yield "limits of the file: where it has any they count, and not those of curves and stubs"
    if options.gradients is None:
        yield "gradients: level, because no profile was joined"
    else:
        yield "gradients: level where the file has none"
    by_listing = any(len(s.tracks) > 1 for s in stations.stations)
    yield (
        f"tracks: {rule.track_half_m:.0f} m or more to either side of a station's place, {rule.stub_m:.0f} m to the "
        f"buffers of a stub, for trains of {rule.train_length_m:g} m"
        + (
            "; how many, and on which side they lie, as the list says, by default 8 m apart about the axis"
            if by_listing
            else ""
        )
    )
    if layout.points:
        normal = (
            "for left-hand running"
            if not any(s.normal for s in stations.stations)
            else "as the list says, else for left-hand running"
        )
        yield (
            f"points: one behind the other, {THROW_TIME_S:g} s to throw, {DIVERGING_KMH:g} km/h on the reverse leg "
            f"(number 12 turnout); normal {normal}"
        )
    yield (
        f"platforms: {2 * rule.platform_half_m:.0f} m at stations, {2 * rule.halt_half_m:.0f} m at halts, about the "
        "station's place; marks that centre the train"
    )
    halts = [s.name for s in stations.stations if s.is_halt]
    if halts:
        yield f"halts: on the section between stations, where one track is listed: {', '.join(halts)}"
    portals = [s.name for s in stations.stations if s.portal]
    if portals:
        beyond = " and ".join(portals)
        yield f"portals: {rule.portal_m:.0f} m of single track beyond {beyond}, for sets from beyond the line"
    yield (
        "coverage: 1.5 km on either side of each station with tracks of its own, as the paper covers only the "
        "surroundings of stations"
    )
    if any(crossing.is_asked for crossing in crossings):
        yield "level crossings: asked by radio; times of the ministry's interpretation of article 62"
        yield "coverage at level crossings: to either side as far as is run in a minute at the greatest speed"
    yield "tags: by the rule of network.tag_layout"
    yield from layout.assumed
