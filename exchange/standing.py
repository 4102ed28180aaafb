"""On which track a set stands at a place where trains end and begin, so that no other needs it meanwhile (番線)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from exchange.planned import TrainOnLine
from network.clock import clock
from network.model import Direction, Line, PlatformTrack, SectionKind
from network.timetable import Call

_BEFORE_S: Final = -(10**9)  # stands there from before the day
_AFTER_S: Final = 10**9
_CLEAR_S: Final = 60  # wanted between two trains on one track, as times are in whole minutes


@dataclass(frozen=True, slots=True)
class StandBetweenTrains:
    """A set that stands at a station between the train it arrives as and the one it leaves as.

    None where it stands there before its first train of the day, or after its last.
    """

    station_id: str
    arrives: TrainOnLine | None
    leaves: TrainOnLine | None

    @property
    def from_s(self) -> int:
        """From when, s."""
        return _BEFORE_S if self.arrives is None else self.arrives.calls[-1].first_s

    @property
    def to_s(self) -> int:
        """Until when, s."""
        return _AFTER_S if self.leaves is None else self.leaves.calls[0].last_s

    def __str__(self) -> str:
        """Whose set it is, for a sentence."""
        if self.arrives is None:
            return f"the set of {self.leaves.number if self.leaves else '?'} from the morning"
        if self.leaves is None:
            return f"the set of {self.arrives.number} to the end of the day"
        return f"the set of {self.arrives.number} that becomes {self.leaves.number}"


@dataclass(frozen=True, slots=True)
class _Use:
    """A track in use: by a set that stands over, or by a train's call on the way.

    In block working it is held for longer: from the departure at the station before to the arrival at the one after.
    """

    from_s: int
    to_s: int
    calls: tuple[tuple[str, int], ...]  # train number, index of its call
    tracks: tuple[PlatformTrack, ...]  # that it can use, the best first
    text: str
    over: bool
    held_from_s: int
    held_to_s: int

    def held_with(self, other: _Use) -> bool:
        """Whether both hold a track at once in block working, so that one of them waits."""
        return self.held_from_s < other.held_to_s and other.held_from_s < self.held_to_s

    def clashes(self, other: _Use, clear_s: int = 0) -> bool:
        """Whether both need a track at once, or within `clear_s` of each other."""
        return self.from_s < other.to_s + clear_s and other.from_s < self.to_s + clear_s


def standing_tracks(
    line: Line, arrives: TrainOnLine | None, leaves: TrainOnLine | None
) -> tuple[PlatformTrack, ...]:
    """Tracks on which a set can end one train and begin the other: marks both ways, and any track they name.

    The usual one of the arriving direction first. Empty where there is none. One of the two trains may be None.
    """
    ends: list[tuple[Call, Direction]] = []
    if arrives is not None:
        ends.append((arrives.calls[-1], arrives.direction))
    if leaves is not None:
        ends.append((leaves.calls[0], leaves.direction))
    return _usable(line, ends)


def night_warnings(line: Line, stands: Sequence[StandBetweenTrains]) -> Iterator[str]:
    """Places where more sets stand at once than there are tracks: at night, and the first time by day."""
    by_station: dict[str, list[StandBetweenTrains]] = {}
    for stand in stands:
        by_station.setdefault(stand.station_id, []).append(stand)
    for station_id, ours in by_station.items():
        station = line.stations[station_id]
        tracks = len({track.section_id for track in station.tracks})
        room = f"{station.name} has {tracks} track{'s' if tracks > 1 else ''}"
        over = False
        for when, at_s in (("before the first train", _BEFORE_S), ("after the last train", _AFTER_S)):
            numbers = [
                (stand.leaves or stand.arrives) for stand in ours if at_s in (stand.from_s, stand.to_s)
            ]
            if len(numbers) > tracks:
                over = True
                trains = ", ".join(train.number for train in numbers if train is not None)
                yield (
                    f"{len(numbers)} sets stand at {station.name} {when} ({trains}), but {room}: "
                    "an empty working (回送) or a portal is missing"
                )
        if over:
            continue
        for stand in sorted(ours, key=lambda stand: stand.from_s):
            at_once = sum(other.from_s <= stand.from_s < other.to_s for other in ours)
            if at_once > tracks:
                yield f"{at_once} sets stand at {station.name} at {clock(stand.from_s)[:-3]}, but {room}"
                break


def give_tracks(
    line: Line, trains: Sequence[TrainOnLine], stands: Sequence[StandBetweenTrains]
) -> tuple[dict[tuple[str, int], str], list[str]]:
    """Tracks by (train number, index of its call), where the usual one will not do; and the clashes that stay.

    Only stations with two tracks or more at which sets stand over. Sets that stand over choose first, where they are
    in the way of the fewest trains; then trains on the way, the usual track if it is free.
    """
    tracks: dict[tuple[str, int], str] = {}
    clashes: list[str] = []
    for station_id in dict.fromkeys(stand.station_id for stand in stands):
        if len(_own_tracks(line, station_id)) < 2:
            continue
        uses = _uses(line, station_id, trains, stands)
        chosen, left = _chosen(uses)
        clashes += [
            f"{line.stations[station_id].name} has no free track for {use.text} at {clock(max(use.from_s, 0))[:-3]}"
            for use in left[:1]
        ]
        for use, track in chosen:
            for key in use.calls:
                tracks[key] = track.name
    usual = {
        (train.number, i): _usable(line, [(call, train.direction)])
        for train in trains
        for i, call in enumerate(train.calls)
        if (train.number, i) in tracks
    }
    needed = {key: name for key, name in tracks.items() if not usual[key] or usual[key][0].name != name}
    return needed, clashes


def _own_tracks(line: Line, station_id: str) -> list[PlatformTrack]:
    return [
        track
        for track in line.stations[station_id].tracks
        if line.sections[track.section_id].kind is SectionKind.TRACK
    ]


def _usable(line: Line, ends: Sequence[tuple[Call, Direction]]) -> tuple[PlatformTrack, ...]:
    """Tracks that serve all these calls at one station; the usual ones first, those of the first call foremost."""
    station_id = ends[0][0].station_id
    usable = [
        track
        for track in line.stations[station_id].tracks
        if all(direction in track.marks_m and call.track in (None, track.name) for call, direction in ends)
    ]
    return tuple(sorted(usable, key=lambda track: [d not in track.directions for _, d in ends]))


def _uses(
    line: Line, station_id: str, trains: Sequence[TrainOnLine], stands: Iterable[StandBetweenTrains]
) -> list[_Use]:
    uses: list[_Use] = []
    paired: set[tuple[str, int]] = set()
    for stand in stands:
        if stand.station_id != station_id:
            continue
        keys: list[tuple[str, int]] = []
        if stand.arrives is not None:
            keys.append((stand.arrives.number, len(stand.arrives.calls) - 1))
        if stand.leaves is not None:
            keys.append((stand.leaves.number, 0))
        paired.update(keys)
        usable = standing_tracks(line, stand.arrives, stand.leaves)
        held_from_s = stand.from_s if stand.arrives is None else _held_from_s(line, stand.arrives, -1)
        held_to_s = stand.to_s if stand.leaves is None else _held_to_s(line, stand.leaves, 0)
        uses.append(
            _Use(stand.from_s, stand.to_s, tuple(keys), usable, str(stand), True, held_from_s, held_to_s)
        )
    for train in trains:
        for i, call in enumerate(train.calls):
            if call.station_id == station_id and (train.number, i) not in paired:
                usable = _usable(line, [(call, train.direction)])
                key = (train.number, i)
                held = (_held_from_s(line, train, i), _held_to_s(line, train, i))
                uses.append(_Use(call.first_s, call.last_s, (key,), usable, train.number, False, *held))
    return uses


def _held_from_s(line: Line, train: TrainOnLine, index: int) -> int:
    """When a train leaves the station with tracks of its own before a call; its time there where there is none."""
    before = [call.last_s for call in train.calls[:index] if not line.stations[call.station_id].is_halt]
    return before[-1] if before else train.calls[index].first_s


def _held_to_s(line: Line, train: TrainOnLine, index: int) -> int:
    """When a train is at the station with tracks of its own after a call; its time there where there is none."""
    after = [call.first_s for call in train.calls[index + 1 :] if not line.stations[call.station_id].is_halt]
    return after[0] if after else train.calls[index].last_s


def _chosen(uses: Sequence[_Use]) -> tuple[list[tuple[_Use, PlatformTrack]], list[_Use]]:
    """A track for each use that can have one free of others, and the uses for which none is."""
    chosen: list[tuple[_Use, PlatformTrack]] = []
    left: list[_Use] = []
    on_the_way = [use for use in uses if not use.over and use.tracks]
    for use in sorted(uses, key=lambda use: (not use.over, use.from_s, use.to_s, use.calls)):

        def cost(track: PlatformTrack, use: _Use = use) -> tuple[int, int, int, int, int]:
            there = [other for other, theirs in chosen if theirs.section_id == track.section_id]
            # trains on the way that have chosen are among `there`; the others are expected on their usual track
            expected = [
                other
                for other in (on_the_way if use.over else ())
                if other.tracks[0].section_id == track.section_id
            ]
            return (
                sum(use.clashes(other) for other in there),
                sum(use.clashes(other) for other in expected),
                sum(use.clashes(other, _CLEAR_S) for other in (*there, *expected)),
                sum(use.held_with(other) for other in (*there, *expected)) if use.over else 0,
                use.tracks.index(track),
            )

        best = min(use.tracks, key=cost, default=None)
        if best is None or cost(best)[0]:
            left.append(use)
        if best is not None:
            chosen.append((use, best))
    return chosen, left
