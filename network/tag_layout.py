"""Where tags (地上子) lie: figure 3 and table 3 of Sugiyama et al. 2017 as a rule that can be rerun.

By direction of travel, with a train of `train_length_m`:

- ARRIVAL (1) on a platform track where a front has the whole train, and a margin, inside the track;
- CONTROL_START (2) a nose before the stopping mark of a platform track;
- DEPARTED (3) between stations (or on a portal) where the whole train, and a margin, has left the station;
- APPROACH (4) before a points section, farther than a service stop from line speed and the throw take;
- POSITION before every mark, halts included, as the beacons of fixed-position stop control (定位置停止制御;
  Oda, section 2.1: about 400 m, 100 m to 200 m and 10 m to 20 m before the mark), and between stations where no other
  tag lies for long;
- PORTAL where a train comes onto the line, for trains of both directions.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

from network.files.line_file import load_line
from network.graph import next_pieces
from network.model import Direction, Line, Piece, PlatformTrack, Section, SectionKind, Tag, TagPurpose

TAGS_PER_STATION: Final = 100  # ids are 100 * (1 + number of the nearest station) + running number
# Assumed: bounds over two tags that grow by 1 % are 120 m wide at most: a stop's first tag is come to and read.
OPEN_LINE_MAX_M: Final = 6_000.0
_OPEN: Final = (SectionKind.BETWEEN, SectionKind.PORTAL)
_BOTH: Final = (Direction.DOWN, Direction.UP)


@dataclass(frozen=True, slots=True)
class TagRule:
    """Distances of the layout, m; `reaction_s` covers the telegrams, the throw and the brake's dead time."""

    train_length_m: float = 40.0
    clear_margin_m: float = 10.0  # bound of the position when the rear is reported clear
    nose_m: float = 5.0
    position_before_m: tuple[float, ...] = (300.0, 100.0, 15.0)
    service_deceleration_mps2: float = 0.7
    reaction_s: float = 10.0
    portal_inset_m: float = 60.0
    short_approach: bool = (
        False  # in a section too short for it, APPROACH lies a nose inside where trains come in
    )

    approach_to_tracks: bool = (
        False  # APPROACH also before a track without points that trains can run through
    )

    def approach_m(self, speed_mps: float) -> float:
        """Distance of APPROACH from the points' section: v t + v^2 / (2 b), up to the next 50 m."""
        need_m = speed_mps * self.reaction_s + speed_mps**2 / (2.0 * self.service_deceleration_mps2)
        return 50.0 * math.ceil(need_m / 50.0)


@dataclass(frozen=True, slots=True)
class _Spot:
    piece_id: str
    position_m: float
    purpose: TagPurpose
    direction: Direction


def lay_tags(line: Line, rule: TagRule | None = None) -> tuple[Tag, ...]:
    """Tags for a line by the rule, in ascending id; those that `line` already has are ignored.

    Raises ValueError for a track or section that is too short for the rule, naming it.
    """
    rule = rule or TagRule()
    spots: dict[tuple[str, float, TagPurpose], list[Direction]] = {}
    by_stations = tuple(_spots(line, rule))
    for spot in (*by_stations, *_far_spots(line, by_stations)):
        key = (spot.piece_id, round(spot.position_m, 3), spot.purpose)
        directions = spots.setdefault(key, [])
        if spot.direction not in directions:
            directions.append(spot.direction)
    return _numbered(line, spots)


def tags_toml(line: Line, tags: Iterable[Tag]) -> str:
    """Tags as `[[tags]]` of a line file, one inline table a row."""
    rows: list[str] = []
    for tag in tags:
        piece = line.pieces[tag.piece_id]
        where = "section" if piece.id == piece.section_id else "piece"
        names = ", ".join(f'"{direction.name.lower()}"' for direction in tag.directions)
        rows.append(
            f'  {{ id = {tag.id}, {where} = "{piece.id}", km = {tag.position_m / 1000.0:.3f},'
            f' purpose = "{tag.purpose.value}", directions = [{names}] }},'
        )
    return "tags = [\n" + "\n".join(rows) + "\n]\n"


def _numbered(line: Line, spots: dict[tuple[str, float, TagPurpose], list[Direction]]) -> tuple[Tag, ...]:
    stations = [station.position_m for station in line.stations.values()]
    used: dict[int, int] = {}
    tags: list[Tag] = []
    for (piece_id, position_m, purpose), directions in sorted(
        spots.items(), key=lambda item: (item[0][1], item[0][0], item[0][2].value)
    ):
        nearest = min(range(len(stations)), key=lambda i: abs(stations[i] - position_m))
        used[nearest] = used.get(nearest, 0) + 1
        if used[nearest] >= TAGS_PER_STATION:
            msg = f"more than {TAGS_PER_STATION - 1} tags around {list(line.stations)[nearest]}"
            raise ValueError(msg)
        number = TAGS_PER_STATION * (nearest + 1) + used[nearest]
        ordered = tuple(direction for direction in _BOTH if direction in directions)
        tags.append(Tag(number, piece_id, position_m, purpose, ordered))
    return tuple(sorted(tags, key=lambda tag: tag.id))


def _spots(line: Line, rule: TagRule) -> Iterator[_Spot]:
    for station in line.stations.values():
        for track in station.tracks:
            for direction, mark_m in track.marks_m.items():
                # no train comes to a mark that has no track behind it, such as the one for leaving a stub
                if next_pieces(line, track.piece_id, direction.opposite):
                    yield from _platform_spots(line, rule, track, direction, mark_m, station.is_halt)
    for section in line.sections.values():
        if section.kind in _OPEN:
            yield from _open_spots(line, rule, section)


def _platform_spots(
    line: Line, rule: TagRule, track: PlatformTrack, direction: Direction, mark_m: float, is_halt: bool
) -> Iterator[_Spot]:
    for before_m in rule.position_before_m:
        for piece_id, position_m in _back(line, track.piece_id, mark_m, direction, before_m):
            yield _Spot(piece_id, position_m, TagPurpose.POSITION, direction)
    if is_halt:
        return
    piece = line.pieces[track.piece_id]
    start_m = mark_m - direction * rule.nose_m
    arrival_m = _entry_m(piece, direction) + direction * (rule.train_length_m + rule.clear_margin_m)
    if (start_m - arrival_m) * direction <= 0.0:
        msg = f"{track.section_id}: a train at the mark has not cleared the rear end of the track"
        raise ValueError(msg)
    yield _Spot(piece.id, arrival_m, TagPurpose.ARRIVAL, direction)
    yield _Spot(piece.id, start_m, TagPurpose.CONTROL_START, direction)


def _open_spots(line: Line, rule: TagRule, section: Section) -> Iterator[_Spot]:
    piece = line.pieces[section.piece_ids[0]]
    for direction in _BOTH:
        if next_pieces(line, piece.id, direction.opposite):
            inside_m = rule.train_length_m + rule.clear_margin_m
            departed_m = _entry_m(piece, direction) + direction * inside_m
            yield _checked(piece, _Spot(piece.id, departed_m, TagPurpose.DEPARTED, direction))
        elif section.kind is SectionKind.PORTAL:
            portal_m = _entry_m(piece, direction) + direction * rule.portal_inset_m
            for read_by in _BOTH:
                yield _checked(piece, _Spot(piece.id, portal_m, TagPurpose.PORTAL, read_by))
        following = [line.pieces[name].section_id for name in next_pieces(line, piece.id, direction)]
        kinds = {line.sections[name].kind for name in following}
        through = any(next_pieces(line, name, direction) for name in next_pieces(line, piece.id, direction))
        to_track = rule.approach_to_tracks and SectionKind.TRACK in kinds and through
        if SectionKind.POINTS in kinds or to_track:
            exit_m = _entry_m(piece, direction.opposite)
            approach_m = exit_m - direction * rule.approach_m(line.max_speed_mps)
            if rule.short_approach and piece.length_m <= rule.approach_m(line.max_speed_mps) + rule.nose_m:
                approach_m = _entry_m(piece, direction) + direction * rule.nose_m
            yield _checked(piece, _Spot(piece.id, approach_m, TagPurpose.APPROACH, direction))


def _far_spots(line: Line, laid: Iterable[_Spot]) -> Iterator[_Spot]:
    """Where trains of a direction would run far without a tag, one evenly every so far, for both directions."""
    for section in line.sections.values():
        if section.kind is not SectionKind.BETWEEN:
            continue
        piece = line.pieces[section.piece_ids[0]]
        added: list[float] = []
        for direction in _BOTH:
            tags = [
                spot.position_m for spot in laid if spot.piece_id == piece.id and spot.direction is direction
            ]
            for from_m, to_m in pairwise(sorted((piece.from_m, *tags, *added, piece.to_m))):
                parts = math.ceil((to_m - from_m) / OPEN_LINE_MAX_M)
                added += [float(round(from_m + part * (to_m - from_m) / parts)) for part in range(1, parts)]
        for position_m in added:
            for direction in _BOTH:
                yield _Spot(piece.id, position_m, TagPurpose.POSITION, direction)


def _entry_m(piece: Piece, direction: Direction) -> float:
    return piece.from_m if direction is Direction.DOWN else piece.to_m


def _checked(piece: Piece, spot: _Spot) -> _Spot:
    if not piece.from_m < spot.position_m < piece.to_m:
        msg = f"{piece.id}: {piece.length_m:.0f} m are too short for its {spot.purpose.value} tag"
        raise ValueError(msg)
    return spot


def _back(
    line: Line, piece_id: str, mark_m: float, direction: Direction, before_m: float
) -> Iterator[tuple[str, float]]:
    """Places `before_m` before a mark, one on each way that leads there; none where the track ends sooner."""
    ways = [(piece_id, mark_m, before_m)]
    while ways:
        name, from_m, left_m = ways.pop()
        entry_m = _entry_m(line.pieces[name], direction)
        here_m = (from_m - entry_m) * direction
        if here_m > left_m:
            yield name, from_m - direction * left_m
            continue
        for previous in next_pieces(line, name, direction.opposite):
            exit_m = _entry_m(line.pieces[previous], direction.opposite)
            ways.append((previous, exit_m, left_m - here_m))


def main(arguments: Sequence[str]) -> int:
    """Print the tags of a line file by the rule, as its `tags` table."""
    line = load_line(Path(arguments[0]))
    sys.stdout.write(tags_toml(line, lay_tags(line)))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
