"""What the two readers of railML make first, and the layout that comes of it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from exchange.layout import (
    ForeignLayout,
    LayoutNode,
    LayoutPoints,
    LayoutSignal,
    LayoutStation,
    LayoutTrack,
    NodeKind,
    Platform,
    Spot,
    count_text,
)
from exchange.layout_draft import SAME_PLACE_M, Merged, carried_kilometrage, merged_pieces
from exchange.xml_input import local_name

# What people call elements that are left; what is not here is called by its own name.
_WORDS: Final = {
    "balise": "balise",
    "baliseGroup": "group of balises",
    "border": "border",
    "bridge": "bridge",
    "brigde": "bridge",
    "underCrossing": "bridge",
    "tunnel": "tunnel",
    "overCrossing": "tunnel",
    "derailer": "derailer",
    "derailerIS": "derailer",
    "electrificationChange": "change of electrification",
    "electrificationSection": "stretch of electrification",
    "etcsArea": "ETCS area",
    "geoMapping": "point of geometry",
    "gradientChange": "change of gradient",
    "gradientCurve": "gradient",
    "horizontalCurve": "curve",
    "levelCrossing": "level crossing",
    "levelCrossingIS": "level crossing",
    "lock": "key lock",
    "keyLockIS": "key lock",
    "mileageChange": "",
    "radiusChange": "change of radius",
    "route": "route",
    "area": "area",
    "genericArea": "area",
    "project": "project",
    "speedChange": "change of speed",
    "speedSection": "stretch of speed",
    "stopPost": "stop post",
    "stoppingPlace": "stop post",
    "trackCircuitBorder": "end of a detection section",
    "trainDetector": "end of a detection section",
    "trainDetectionElement": "end of a detection section",
    "trainProtectionChange": "change of train protection",
    "trainProtectionElement": "train protection",
    "controller": "controller",
    "line": "line",
    "lineSection": "section of a line",
    "speedProfile": "speed profile",
}
_PLURALS: Final = {
    "group of balises": "groups of balises",
    "change of electrification": "changes of electrification",
    "stretch of electrification": "stretches of electrification",
    "point of geometry": "points of geometry",
    "change of gradient": "changes of gradient",
    "change of radius": "changes of radius",
    "change of speed": "changes of speed",
    "stretch of speed": "stretches of speed",
    "end of a detection section": "ends of detection sections",
    "change of train protection": "changes of train protection",
    "train protection": "train protections",
    "section of a line": "sections of a line",
}


@dataclass(slots=True)
class RailmlDraft:
    """What a reader found, by pieces of track: those of points are pieces too, until the pieces are merged.

    `crossings` are node ids with what is said of each.
    """

    name: str
    pieces: list[LayoutTrack] = field(default_factory=list)
    kinds: dict[str, NodeKind] = field(default_factory=dict)
    points: list[LayoutPoints] = field(default_factory=list)
    crossings: dict[str, str] = field(default_factory=dict)
    stations: list[LayoutStation] = field(default_factory=list)
    signals: list[LayoutSignal] = field(default_factory=list)
    not_in_use: int = 0
    assumed: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)


def layout_of(draft: RailmlDraft, source: str) -> ForeignLayout:
    """The layout of a draft: cuts without a meaning undone, kilometrage carried over, everything counted."""
    fixed = frozenset({entry.node_id for entry in draft.points} | set(draft.crossings))
    done = merged_pieces(draft.pieces, fixed)
    points = tuple(_points(entry, done) for entry in draft.points)
    tracks, given = carried_kilometrage(done.tracks, points)
    by_id = {track.id: track for track in tracks}
    stations = tuple(_station(entry, done, by_id, draft) for entry in draft.stations)
    signals = tuple(
        replace(
            signal,
            track_id=done.moved[signal.track_id].track_id,
            offset_m=done.moved[signal.track_id].offset_m(signal.offset_m),
            forward=signal.forward == (done.moved[signal.track_id].sign > 0),
        )
        for signal in draft.signals
    )
    nodes = tuple(_nodes(tracks, draft, {entry.node_id for entry in draft.points}))
    platforms = sum(len(station.platforms) for station in stations)
    used = [
        f"{count_text(len(tracks), 'track')} of {sum(track.length_m for track in tracks) / 1000:.3f} km in all",
        count_text(len(points), "set of ordinary points", "sets of ordinary points"),
        f"{count_text(len(stations), 'station')} with {count_text(platforms, 'platform')}",
        count_text(len(signals), "signal"),
    ]
    jumps = sum(_jumps(track) for track in tracks)
    if jumps:
        used.append(count_text(jumps, "jump of the kilometrage", "jumps of the kilometrage"))
    assumed = list(draft.assumed)
    if draft.points:
        assumed.append("the normal leg of points is the one that the track continues on")
    if draft.not_in_use:
        what = count_text(draft.not_in_use, "element")
        assumed.append(f"{what} marked planned, closed or disabled: taken as if in use where taken at all")
    if given:
        assumed.append(
            f"kilometrage of {count_text(len(given), 'track')} carried over from those they continue"
        )
    without = [track for track in tracks if not track.kilometrage]
    if without:
        draft.left.append(f"no kilometrage: {', '.join(track.name or track.id for track in without)}")
    left = [f"not among points: {text}" for text in draft.crossings.values()] + draft.left
    return ForeignLayout(
        draft.name,
        source,
        nodes,
        tuple(tracks),
        points,
        stations,
        signals,
        (),
        tuple(used),
        tuple(assumed),
        tuple(left),
    )


def left_of(elements: Iterable[ET.Element], used: frozenset[str]) -> list[str]:
    """One sentence for what has an id and is not taken, counted by its kind."""
    counts: Counter[str] = Counter()
    for element in elements:
        name = local_name(element)
        if element.get("id") and name not in used:
            word = _WORDS.get(name, name)
            if word:
                counts[word] += 1
    return [count_text(count, word, _PLURALS.get(word, "")) for word, count in sorted(counts.items())]


def states_not_in_use(words: Iterable[tuple[str, bool]]) -> int:
    """How many states, each a word and whether disabled, are of something that is not in use."""
    return sum(
        disabled or word in ("planned", "closed", "conceptual", "disabled") for word, disabled in words
    )


def _points(entry: LayoutPoints, done: Merged) -> LayoutPoints:
    stem, normal, reverse = (
        done.moved[piece].track_id for piece in (entry.stem, entry.normal, entry.reverse)
    )
    return replace(entry, stem=stem, normal=normal, reverse=reverse)


def _station(
    entry: LayoutStation, done: Merged, tracks: Mapping[str, LayoutTrack], draft: RailmlDraft
) -> LayoutStation:
    spots = tuple(
        Spot(
            done.moved[spot.track_id].track_id,
            done.moved[spot.track_id].offset_m(spot.offset_m),
            spot.track_name,
        )
        for spot in entry.spots
    )
    platforms: list[Platform] = []
    for platform in entry.platforms:
        moved = done.moved[platform.track_id]
        low_m, high_m = sorted((moved.offset_m(platform.from_m), moved.offset_m(platform.to_m)))
        platforms.append(Platform(moved.track_id, low_m, high_m, platform.name))
    places = [tracks[spot.track_id].km_m(spot.offset_m) for spot in spots]
    called = "its places"
    if not spots:
        places = [tracks[p.track_id].km_m((p.from_m + p.to_m) / 2) for p in platforms]
        called = "the middles of its platforms"
        if platforms:
            draft.assumed.append(f"{entry.name or entry.key} lies at the middle of its platform")
    known = [place for place in places if place is not None]
    if known and max(known) - min(known) > SAME_PLACE_M:
        draft.assumed.append(
            f"{entry.name or entry.key} lies at the mean of {called}, which are {max(known) - min(known):.0f} m apart"
        )
    position_m = round(sum(known) / len(known), 6) if known else None
    if position_m is None:
        draft.left.append(f"no place on the tracks: station {entry.name or entry.key}")
    return replace(entry, position_m=position_m, spots=spots, platforms=tuple(platforms))


def _nodes(tracks: Iterable[LayoutTrack], draft: RailmlDraft, toes: set[str]) -> Iterable[LayoutNode]:
    seen: dict[str, int] = {}
    for track in tracks:
        for node_id in (track.low_node, track.high_node):
            seen[node_id] = seen.get(node_id, 0) + 1
    for node_id, ends in seen.items():
        if node_id in toes:
            kind = NodeKind.POINTS
        elif node_id in draft.crossings or ends > 2:
            kind = NodeKind.CROSSING
        elif ends == 2:
            kind = NodeKind.JOINT
        else:
            kind = draft.kinds.get(node_id, NodeKind.OPEN)
        yield LayoutNode(node_id, kind)


def _jumps(track: LayoutTrack) -> int:
    offsets = [offset_m for offset_m, _ in track.kilometrage]
    return len(offsets) - len(set(offsets))
