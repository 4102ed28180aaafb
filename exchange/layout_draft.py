"""From the pieces of track that a source has to a layout: ends joined to nodes, cuts without a meaning undone,
kilometrage carried over to tracks that have none of their own.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from exchange.layout import KmRow, LayoutPoints, LayoutTrack, Place

SAME_PLACE_M: Final = 0.5  # two offsets, or two kilometrages, that are one

End = tuple[str, int]  # a piece of track and which end of it: 0 the low one, 1 the high one


class JoinedEnds:
    """Which ends are one node, as pairs say."""

    def __init__(self) -> None:
        self._over: dict[End, End] = {}

    def node_end(self, end: End) -> End:
        """The end that stands for its whole node."""
        self._over.setdefault(end, end)
        while self._over[end] != end:
            self._over[end] = self._over[self._over[end]]
            end = self._over[end]
        return end

    def join(self, one: End, other: End) -> None:
        """These two ends are one place."""
        first, second = sorted((self.node_end(one), self.node_end(other)))
        self._over[second] = first


@dataclass(frozen=True, slots=True)
class PieceOnTrack:
    """Where a piece of the source lies on a track: `sign` -1 if it runs against it."""

    track_id: str
    base_m: float
    sign: int

    def offset_m(self, offset_m: float) -> float:
        """Offset on the track of an offset on the piece, m."""
        return round(self.base_m + self.sign * offset_m, 6)


@dataclass(slots=True)
class Merged:
    """Tracks after merging, and where each piece went."""

    tracks: list[LayoutTrack] = field(default_factory=list)
    moved: dict[str, PieceOnTrack] = field(default_factory=dict)


def merged_pieces(pieces: Iterable[LayoutTrack], fixed: frozenset[str]) -> Merged:
    """Join pieces end to end where just two of one name and kind meet at a node that is not `fixed`.

    A source may cut a track for reasons that are no part of the layout: at a change of kilometrage, of speed, at a
    bridge. The merged track has the id and the sense of its first piece in the order given.
    """
    by_id = {piece.id: piece for piece in pieces}
    at: dict[str, list[str]] = defaultdict(list)
    for piece in by_id.values():
        at[piece.low_node].append(piece.id)
        at[piece.high_node].append(piece.id)

    def beyond(piece: LayoutTrack, node: str) -> LayoutTrack | None:
        there = at[node]
        if node in fixed or len(there) != 2 or there[0] == there[1]:
            return None
        other = by_id[there[1] if there[0] == piece.id else there[0]]
        return other if (other.name, other.kind) == (piece.name, piece.kind) else None

    done = Merged()
    for piece in by_id.values():
        if piece.id in done.moved:
            continue
        chain = [(piece, 1)]
        chain += _chained(piece, piece.high_node, beyond, {piece.id})
        seen = {one.id for one, _ in chain}
        before = _chained(piece, piece.low_node, beyond, seen)
        chain = [(one, -sign) for one, sign in reversed(before)] + chain
        _put(done, piece, chain)
    return done


def _chained(
    piece: LayoutTrack, node: str, beyond: Callable[[LayoutTrack, str], LayoutTrack | None], seen: set[str]
) -> list[tuple[LayoutTrack, int]]:
    """Pieces that follow over `node`, each with +1 if it is walked from its low node."""
    found: list[tuple[LayoutTrack, int]] = []
    while True:
        following = beyond(piece, node)
        if following is None or following.id in seen:
            return found
        sign = 1 if following.low_node == node else -1
        found.append((following, sign))
        seen.add(following.id)
        piece, node = following, following.high_node if sign > 0 else following.low_node


def _put(done: Merged, first: LayoutTrack, chain: list[tuple[LayoutTrack, int]]) -> None:
    at_m = 0.0
    shape: list[Place] = []
    rows: list[KmRow] = []
    whole = all(piece.shape for piece, _ in chain)
    for piece, sign in chain:
        base_m = at_m if sign > 0 else at_m + piece.length_m
        moved = PieceOnTrack(first.id, round(base_m, 6), sign)
        done.moved[piece.id] = moved
        if whole:
            ordered = piece.shape if sign > 0 else piece.shape[::-1]
            shape += ordered[1:] if shape else ordered
        rows += sorted(
            ((moved.offset_m(offset_m), km_m) for offset_m, km_m in piece.kilometrage[::sign]),
            key=lambda row: row[0],
        )
        at_m = round(at_m + piece.length_m, 6)
    (head, head_sign), (tail, tail_sign) = chain[0], chain[-1]
    done.tracks.append(
        LayoutTrack(
            first.id,
            first.name,
            first.kind,
            head.low_node if head_sign > 0 else head.high_node,
            tail.high_node if tail_sign > 0 else tail.low_node,
            at_m,
            tuple(shape),
            _rows_of_chain(at_m, rows),
        )
    )


def _rows_of_chain(length_m: float, rows: list[KmRow]) -> tuple[KmRow, ...]:
    """Rows of pieces end to end: where two meet at one kilometrage there is no row, where it jumps there are two."""
    known: list[KmRow] = []
    jumps: list[tuple[float, float, float]] = []
    for row in rows:
        if known and row[0] - known[-1][0] < SAME_PLACE_M and 0.0 < row[0] < length_m:
            if abs(row[1] - known[-1][1]) > SAME_PLACE_M:
                jumps.append((row[0], known[-1][1], row[1]))
            continue
        known.append(row)
    return km_rows(length_m, known, jumps)


def km_rows(
    length_m: float, known: Iterable[KmRow], jumps: Iterable[tuple[float, float, float]]
) -> tuple[KmRow, ...]:
    """The kilometrage of a piece of track from what is known of it; empty where nothing is.

    `known` are offsets with their kilometrages; `jumps` offsets with the kilometrage before and after. Between jumps it
    runs on metre for metre beyond the first and the last offset known.
    """
    cuts = sorted(jumps)
    bounds = [0.0, *(offset_m for offset_m, _, _ in cuts), length_m]
    parts: list[list[KmRow]] = [[] for _ in range(len(cuts) + 1)]
    for number, (offset_m, before_m, after_m) in enumerate(cuts):
        parts[number].append((offset_m, before_m))
        parts[number + 1].append((offset_m, after_m))
    for offset_m, km_m in known:
        inside = [n for n in range(len(parts)) if bounds[n] <= offset_m <= bounds[n + 1]]
        # At a jump both sides claim the offset: it has its two kilometrages already.
        if len(inside) == 1:
            parts[inside[0]].append((offset_m, km_m))
    senses = [sense for part in parts if (sense := _sense(part))]
    sense = senses[0] if senses else 1
    rows: list[KmRow] = []
    for number, part in enumerate(parts):
        low_m, high_m = bounds[number], bounds[number + 1]
        if not part or high_m - low_m < SAME_PLACE_M:
            continue
        part.sort(key=lambda row: row[0])
        first, last = part[0], part[-1]
        if first[0] - low_m > 0:
            part.insert(0, (low_m, first[1] - sense * (first[0] - low_m)))
        if high_m - last[0] > 0:
            part.append((high_m, last[1] + sense * (high_m - last[0])))
        rows += _thinned(part)
    return tuple((round(offset_m, 6), round(km_m, 6)) for offset_m, km_m in rows)


def _sense(part: list[KmRow]) -> int:
    """Whether kilometrage grows with the offset; 0 where less than two places are known."""
    if len(part) < 2:
        return 0
    (_, low_m), (_, high_m) = min(part), max(part)
    return (high_m > low_m) - (high_m < low_m)


def _thinned(part: list[KmRow]) -> list[KmRow]:
    """Rows without those that straight lines between the others say too, and without a second at one offset."""
    (low_m, low_km_m), (high_m, high_km_m) = part[0], part[-1]

    def off_m(index: int) -> float:
        offset_m, km_m = part[index]
        if offset_m - low_m < SAME_PLACE_M or high_m - offset_m < SAME_PLACE_M:
            return 0.0
        return abs(low_km_m + (offset_m - low_m) * (high_km_m - low_km_m) / (high_m - low_m) - km_m)

    worst = max(range(1, len(part) - 1), key=off_m, default=0)
    if not worst or off_m(worst) <= SAME_PLACE_M:
        return [part[0], part[-1]]
    return [*_thinned(part[: worst + 1]), *_thinned(part[worst:])[1:]]


def carried_kilometrage(
    tracks: Sequence[LayoutTrack], points: Iterable[LayoutPoints], *, names_are_lines: bool = False
) -> tuple[list[LayoutTrack], list[str]]:
    """Kilometrage for tracks without one, from those that they continue or lie beside at points.

    Returns the tracks, and the ids of those that were given one. A track both of whose nodes are known is stretched
    between them; else it runs on metre for metre. Where names of tracks are those of lines, one line's kilometrage
    goes to no track of another line.
    """
    by_id = {track.id: track for track in tracks}
    at: dict[str, list[str]] = defaultdict(list)
    for track in tracks:
        at[track.low_node].append(track.id)
        at[track.high_node].append(track.id)
    stems = {entry.node_id: entry.stem for entry in points}
    given: list[str] = []
    waiting = [track.id for track in tracks if track.kilometrage]
    line_of = {track_id: by_id[track_id].name for track_id in waiting}
    for known in waiting:  # grows while it is walked: what was given one passes it on
        for node, other in _neighbours(by_id[known], at, stems):
            if by_id[other].kilometrage:
                continue
            named = by_id[other].name
            if names_are_lines and named and line_of[known] and named != line_of[known]:
                continue
            line_of[other] = line_of[known] or named
            by_id[other] = _continued(by_id[known], by_id[other], node, stems, by_id, at)
            given.append(other)
            waiting.append(other)
    return [by_id[track.id] for track in tracks], given


def _neighbours(
    track: LayoutTrack, at: Mapping[str, list[str]], stems: Mapping[str, str]
) -> Iterator[tuple[str, str]]:
    for node in (track.low_node, track.high_node):
        if node in stems or len(at[node]) == 2:
            yield from ((node, other) for other in at[node] if other != track.id)


def _continued(
    known: LayoutTrack,
    other: LayoutTrack,
    node: str,
    stems: Mapping[str, str],
    by_id: Mapping[str, LayoutTrack],
    at: Mapping[str, list[str]],
) -> LayoutTrack:
    here_m, toward = _at_node(known, node)
    same_side = node in stems and stems[node] not in (known.id, other.id)
    away = -toward if same_side else toward  # sense of kilometrage on the other, going away from the node
    far = other.high_node if other.low_node == node else other.low_node
    there_m = here_m + away * other.length_m
    for third in at[far]:
        if third != other.id and by_id[third].kilometrage and (far in stems or len(at[far]) == 2):
            found_m = _at_node(by_id[third], far)[0]
            # Another way round to the same place may be a little longer; a different kilometrage is another line's.
            if abs(found_m - there_m) < 0.2 * other.length_m:
                there_m = found_m
    rows = ((0.0, here_m), (other.length_m, there_m))
    if other.low_node != node:
        rows = ((0.0, there_m), (other.length_m, here_m))
    return replace(other, kilometrage=rows)


def _at_node(track: LayoutTrack, node: str) -> tuple[float, int]:
    """Kilometrage, m, at one of a track's nodes, and +1 if it grows towards it."""
    rows = track.kilometrage
    end, before = (rows[-1], rows[-2]) if track.high_node == node else (rows[0], rows[1])
    return end[1], 1 if end[1] >= before[1] else -1
