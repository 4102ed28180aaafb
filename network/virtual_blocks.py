"""Sections between stations cut into virtual blocks of equal length (decision 111).

Nothing is laid in the track: a block ends at a kilometrage, and its train's position proves it clear, as any section.
A border that would fall into a platform is moved to beyond it, so that a train stands at a halt within one block.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Final

from network.model import Line, Piece, PlatformTrack, Section, SectionKind, Station

BEYOND_M: Final = (
    60.0  # assumed: from a platform's end to a border beside it: half a train of the lines here and more
)


def radio_reaches(line: Line, section: Section) -> bool:
    """Whether the radio reaches a train wherever it stands in a section."""
    pieces = [line.pieces[piece_id] for piece_id in section.piece_ids]
    return all(
        any(c.from_m <= p.from_m and p.to_m <= c.to_m for c in line.alignments[p.alignment_id].coverage)
        for p in pieces
    )


def with_virtual_blocks(line: Line, blocks: int) -> Line:
    """The line with each section between stations in so many blocks; ValueError below one."""
    between = (s.id for s in line.sections.values() if s.kind is SectionKind.BETWEEN)
    return with_blocks_of(line, dict.fromkeys(between, blocks))


def with_blocks_of(line: Line, blocks: Mapping[str, int]) -> Line:
    """The line with each of these sections between stations in so many blocks; ValueError below one."""
    for section_id, count in blocks.items():
        if count < 1:
            raise ValueError("a section is one block at least")
        if count > 1:
            line = _cut(line, line.sections[section_id], count)
    return line


def _cut(line: Line, section: Section, blocks: int) -> Line:
    (piece_id,) = section.piece_ids
    piece = line.pieces[piece_id]
    borders = _borders(line, piece, blocks)
    ends = (piece.from_m, *borders, piece.to_m)
    nodes = (piece.low_node, *(f"{piece.id}/{i}" for i in range(1, len(borders) + 1)), piece.high_node)
    names = [f"{section.id}_{i}" for i in range(1, len(ends))]
    pieces = [
        replace(piece, id=name, section_id=name, from_m=low_m, to_m=high_m, low_node=low, high_node=high)
        for name, (low_m, high_m), (low, high) in zip(names, pairwise(ends), pairwise(nodes), strict=True)
    ]
    sections = [replace(section, id=name, piece_ids=(name,)) for name in names]
    return _rebuilt(line, section, sections, pieces)


def _borders(line: Line, piece: Piece, blocks: int) -> tuple[float, ...]:
    """Where blocks meet: even parts, beside platforms; two that come to one place are one."""
    kept_free = sorted(
        (track.platform_m[0] - BEYOND_M, track.platform_m[1] + BEYOND_M)
        for station in line.stations.values()
        for track in station.tracks
        if track.piece_id == piece.id and track.platform_m is not None
    )
    platforms: list[tuple[float, float]] = []
    for low_m, high_m in kept_free:  # beside one may be another
        joins = bool(platforms) and low_m < platforms[-1][1]
        before = platforms.pop() if joins else (low_m, high_m)
        platforms.append((before[0], max(before[1], high_m)))
    found: list[float] = []
    for i in range(1, blocks):
        at_m = piece.from_m + piece.length_m * i / blocks
        for low_m, high_m in platforms:
            if low_m < at_m < high_m:
                at_m = low_m if at_m - low_m < high_m - at_m else high_m
        if piece.from_m < at_m < piece.to_m and (not found or at_m > found[-1]):
            found.append(at_m)
    return tuple(found)


def _rebuilt(line: Line, section: Section, sections: list[Section], pieces: list[Piece]) -> Line:
    """The line with a section and its piece replaced, and all that lies on that piece on the new ones."""
    old_id = section.piece_ids[0]

    def at(position_m: float) -> Piece:
        return next((p for p in pieces if position_m < p.to_m), pieces[-1])

    def placed(track: PlatformTrack) -> PlatformTrack:
        if track.piece_id != old_id:
            return track
        own = at(sum(track.marks_m.values()) / len(track.marks_m))
        return replace(track, piece_id=own.id, section_id=own.section_id)

    def stationed(station: Station) -> Station:
        return replace(station, tracks=tuple(placed(track) for track in station.tracks))

    kept = {piece_id: piece for piece_id, piece in line.pieces.items() if piece_id != old_id}
    return replace(
        line,
        sections=_in_place(line, section, sections),
        pieces={**kept, **{piece.id: piece for piece in pieces}},
        stations={station.id: stationed(station) for station in line.stations.values()},
        tags={
            tag.id: replace(tag, piece_id=at(tag.position_m).id) if tag.piece_id == old_id else tag
            for tag in line.tags.values()
        },
        beacons={
            one.id: replace(one, piece_id=at(one.position_m).id) if one.piece_id == old_id else one
            for one in line.beacons.values()
        },
        markers={
            one.id: replace(one, piece_id=at(one.position_m).id) if one.piece_id == old_id else one
            for one in line.markers.values()
        },
        crossings={
            one.id: replace(one, piece_id=at(one.position_m).id) if one.piece_id == old_id else one
            for one in line.crossings.values()
        },
    )


def _in_place(line: Line, section: Section, sections: list[Section]) -> dict[str, Section]:
    """The sections in their order, the new ones where the old one was."""
    found: dict[str, Section] = {}
    for one in line.sections.values():
        found |= {s.id: s for s in (sections if one.id == section.id else [one])}
    return found
