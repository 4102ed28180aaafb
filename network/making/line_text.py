"""A line file's text from what was laid out and joined: the tables in the order of the shipped files, tags in front."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from network.files.line_file import parse_line
from network.files.toml_text import text_toml
from network.making.crossing_places import LaidCrossing
from network.making.layout import LaidStation, LayoutRule, LineLayout, coverage_m
from network.model import Alignment, Direction
from network.tag_layout import lay_tags, tags_toml
from network.units import metres

EQUIPPED: Final = (
    "# assumed: supervision guarantees the stop before the points, so opposing trains come in at once"
)
THROW_TIME_S: Final = 6.0
DIVERGING_KMH: Final = 45.0
_NAMES: Final = {Direction.DOWN: "down", Direction.UP: "up"}


@dataclass(frozen=True, slots=True)
class LineHeader:
    """What `[line]` says, and the comment before everything."""

    id: str
    name: str
    name_ja: str
    max_speed_kmh: float
    sources: tuple[str, ...]
    assumed: tuple[str, ...]
    comment: tuple[str, ...]


def line_toml(
    words: LineHeader,
    alignment: Alignment,
    layout: LineLayout,
    rule: LayoutRule,
    crossings: Sequence[LaidCrossing] = (),
) -> str:
    """The whole file. Raises InputError or ValueError where the result is no line: a mistake in the layout."""
    bare = "\n".join(
        [
            *_head(words),
            *_alignment(alignment, layout, [c.asked_m(rule.max_speed_mps) for c in crossings if c.is_asked]),
            *_sections(layout),
            *_points(layout),
            *_joints(layout),
            *(row for station in layout.stations for row in _station(station, rule)),
            *(row for crossing in crossings for row in _crossing(crossing)),
        ]
    )
    line = parse_line(bare, words.id)
    comment = "".join(f"# {text}\n" for text in words.comment)
    return f"{comment}\n{tags_toml(line, lay_tags(line, rule.tags))}\n{bare}\n"


def km_text(position_m: float) -> str:
    """Kilometres of a position in metres, to the micrometre and no longer than needed."""
    text = f"{position_m / 1000.0:.9f}".rstrip("0")
    text = text + "0" if text.endswith(".") else text
    return text.removeprefix("-") if float(text) == 0.0 else text


def _head(words: LineHeader) -> Iterable[str]:
    yield "[line]"
    yield f"id = {text_toml(words.id)}"
    yield f"name = {text_toml(words.name)}"
    if words.name_ja:
        yield f"name_ja = {text_toml(words.name_ja)}"
    yield f"max_speed_kmh = {words.max_speed_kmh:g}"
    yield f"overlap_m = 0 {EQUIPPED}"
    for key, texts in (("sources", words.sources), ("assumed", words.assumed)):
        if texts:
            yield from (f"{key} = [", *(f"  {text_toml(text)}," for text in texts), "]")


def _alignment(line: Alignment, layout: LineLayout, roads: Sequence[tuple[float, float]]) -> Iterable[str]:
    yield from ("", "[[alignments]]", f"id = {text_toml(line.id)}")
    yield f"from_km = {km_text(line.from_m)}"
    yield f"to_km = {km_text(line.to_m)}"
    yield f"x_m = {line.x_m}"
    yield f"y_m = {line.y_m}"
    yield f"bearing_deg = {line.bearing_deg}"
    yield f"elevation_m = {line.elevation_m}"
    yield from _table(
        "gradients", [f"{_range(g.from_m, g.to_m)}, permille = {g.permille:g}" for g in line.gradients]
    )
    yield from _table(
        "curves",
        [
            f"{_range(c.from_m, c.to_m)}, radius_m = {c.radius_m:g}, transition_m = {c.transition_m:.3f},"
            f" cant_mm = {c.cant_mm:g}"
            for c in line.curves
        ],
    )
    yield from _table(
        "limits",
        [
            f"{_range(x.from_m, x.to_m)}, speed_kmh = {round(x.speed_mps * 3.6, 6):g}{_directions(x.directions)}"
            for x in line.limits
        ],
    )
    yield from _table("coverage", [_range(low_m, high_m) for low_m, high_m in coverage_m(layout, roads)])


def _directions(directions: Sequence[Direction]) -> str:
    if len(directions) == 2:
        return ""
    return f', directions = ["{_NAMES[directions[0]]}"]'


def _range(from_m: float, to_m: float) -> str:
    return f"from_km = {km_text(from_m)}, to_km = {km_text(to_m)}"


def _table(name: str, rows: Sequence[str]) -> Iterable[str]:
    if rows:
        yield from (f"{name} = [", *(f"  {{ {row} }}," for row in rows), "]")


def _sections(layout: LineLayout) -> Iterable[str]:
    for section in layout.sections:
        yield from ("", "[[sections]]", f'id = "{section.id}"', f'kind = "{section.kind}"')
        if section.from_m is not None and section.to_m is not None:
            yield f"from_km = {km_text(section.from_m)}"
            yield f"to_km = {km_text(section.to_m)}"
        if section.offset_m:
            yield f"offset_m = {section.offset_m}"


def _points(layout: LineLayout) -> Iterable[str]:
    for points in layout.points:
        yield from ("", "[[points]]", f'id = "{points.id}"', f'section = "{points.section}"')
        yield f'terminal = "{points.terminal}"'
        for key, at_m in (("from_km", points.from_m), ("toe_km", points.toe_m), ("to_km", points.to_m)):
            yield f"{key} = {km_text(at_m)}"
        if points.offset_m:
            yield f"offset_m = {points.offset_m}"
        yield f'faces = "{points.faces}"'
        for key, name in (("stem", points.stem), ("normal", points.normal), ("reverse", points.reverse)):
            yield f'{key} = "{name}"'
        yield f"throw_time_s = {THROW_TIME_S}"
        yield f"diverging_limit_kmh = {DIVERGING_KMH:g}"


def _crossing(crossing: LaidCrossing) -> Iterable[str]:
    row = crossing.row
    yield from ("", "[[crossings]]", f'id = "{crossing.id}"', f'section = "{crossing.section}"')
    yield f"km = {km_text(metres(row.km))}"
    if row.name:
        yield f"name = {text_toml(row.name)}"
    yield f'kind = "{row.kind}"'
    yield f"width_m = {row.width_m:g}"


def _joints(layout: LineLayout) -> Iterable[str]:
    for low, high in layout.joints:
        yield from ("", "[[joints]]", f'low = "{low}"', f'high = "{high}"')


def _station(station: LaidStation, rule: LayoutRule) -> Iterable[str]:
    listed = station.listed
    yield from ("", "[[stations]]", f'id = "{listed.id}"', f"name = {text_toml(listed.name)}")
    if listed.name_ja:
        yield f"name_ja = {text_toml(listed.name_ja)}"
    yield f"km = {km_text(station.place_m)}"
    yield f"halt = {'true' if listed.is_halt else 'false'}"
    half_m = rule.halt_half_m if listed.is_halt else rule.platform_half_m
    rows: list[str] = []
    for track in station.tracks:
        cells = [f'name = "{track.name}"', f'section = "{track.section}"']
        if listed.has_platforms:
            cells.append(f"platform_from_km = {km_text(station.place_m - half_m)}")
            cells.append(f"platform_to_km = {km_text(station.place_m + half_m)}")
        cells.append(f"mark_down_km = {km_text(station.place_m + rule.mark_m)}")
        cells.append(f"mark_up_km = {km_text(station.place_m - rule.mark_m)}")
        usual = ", ".join(f'"{name}"' for name in track.directions)
        rows.append(", ".join((*cells, f"directions = [{usual}]")))
    yield from _table("tracks", rows)
