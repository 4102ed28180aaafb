"""The path databases of a run in contiguous arrays, so that compiled code finds every train's path by offset."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from network.model import Direction, Line
from network.path import Path, path_of
from network.profile import PROFILE, profile_of
from onboard.driving.laws.cue import PLAN
from onboard.driving.pattern import pattern_of
from onboard.records import NO_PLACES, PATTERN, PLACE, PLACE_BEACON, PLACE_MARKERS, BehaviourRow
from simulation.world.collation import LaidCurvatureMap
from simulation.world.irregularities import Irregularities
from simulation.world.kernel import PathArrays
from vehicle.records import TrainRow


@dataclass(frozen=True, slots=True)
class PathRows:
    """Where one path's rows, tags and places lie in the pool."""

    offset: int
    rows: int
    tag_first: int
    tag_end: int
    beacon_first: int
    markers_first: int  # where its beacons end
    markers_end: int
    known_first: int  # places that units know of
    known_end: int


def beacons_on(line: Line, path: Path) -> NDArray[np.void]:
    """Rows of PLACE: the beacons that trains on a path pass, by position."""
    passed = [
        (PLACE_BEACON, path.to_path_m(b.piece_id, b.position_m), b.id, b.tells_id, b.used, b.window_m or 0.0)
        for b in line.beacons.values()
        if b.piece_id in path and path.direction in b.directions
    ]
    return np.array(sorted(passed, key=lambda row: row[1]), dtype=PLACE)


def markers_on(line: Line, path: Path, broken: Collection[int] = ()) -> NDArray[np.void]:
    """Rows of PLACE: the groups of markers that trains on a path see, by position.

    Of a `broken` group (id) the number is negative: it shows no pattern.
    """
    seen = [
        (
            PLACE_MARKERS,
            path.to_path_m(m.piece_id, m.position_m),
            -m.pattern if m.id in broken else m.pattern,
            True,
            True,
            0.0,
        )
        for m in line.markers.values()
        if m.piece_id in path and path.direction in m.directions
    ]
    return np.array(sorted(seen, key=lambda row: row[1]), dtype=PLACE)


class PathPool:
    """Grows by one entry for each path and kind of train; entries never move.

    Profile and tags are of the line as it is, with the `rails` as laid; patterns are of the line as units believe it to
    be, with the map that they have `charted`.
    """

    def __init__(
        self,
        line: Line,
        believed: Line | None = None,
        rails: Irregularities | None = None,
        charted: LaidCurvatureMap | None = None,
    ) -> None:
        self._line = line
        self._rails = rails
        self._charted = charted
        self._believed = line if believed is None else believed
        self._known: dict[tuple[tuple[str, ...], Direction, str], PathRows] = {}
        self.profile: NDArray[np.void] = np.zeros(0, dtype=PROFILE)
        self.pattern: NDArray[np.void] = np.zeros(0, dtype=PATTERN)
        self.plan: NDArray[np.void] = np.zeros(0, dtype=PLAN)
        self._plan_room: dict[
            int, tuple[int, int]
        ] = {}  # of each slot: where its plan begins, rows it may take
        self.tag_positions_m: NDArray[np.float64] = np.zeros(0)
        self.tag_ids: list[int] = []
        self.places: NDArray[np.void] = NO_PLACES
        self.known_places: NDArray[np.void] = NO_PLACES
        self._broken: set[int] = set()  # groups of markers that show no pattern

    def rows_for(self, path: Path, train_id: str, train: TrainRow, behaviour: BehaviourRow) -> PathRows:
        """The rows of a path for a kind of train; computed once."""
        key = (path.piece_ids, path.direction, train_id)
        laid = self._known.get(key)
        if laid is not None:
            return laid
        profile = profile_of(self._line, path)
        believed = profile if self._believed is self._line else profile_of(self._believed, path)
        pattern = pattern_of(
            np.ascontiguousarray(believed["elevation_m"]),
            np.ascontiguousarray(believed["turn_rad"]),
            np.ascontiguousarray(believed["limit_mps"]),
            train,
            behaviour,
        )
        if self._rails is not None:
            profile["irregularity_rad"] = self._rails.on_path_rad(path)
        if self._charted is not None:
            pattern["curvature_per_m"] = self._charted.along(path)
        tags = sorted(
            (path.to_path_m(tag.piece_id, tag.position_m), tag.id)
            for tag in self._line.tags.values()
            if tag.piece_id in path and path.direction in tag.directions
        )
        beacons, markers = beacons_on(self._line, path), markers_on(self._line, path, self._broken)
        known = np.concatenate([beacons_on(self._believed, path), markers_on(self._believed, path)])
        known.sort(order="position_m", kind="stable")
        first = self.places.size
        rows = PathRows(
            self.profile.size,
            profile.size,
            len(self.tag_ids),
            len(self.tag_ids) + len(tags),
            first,
            first + beacons.size,
            first + beacons.size + markers.size,
            self.known_places.size,
            self.known_places.size + known.size,
        )
        self.places = np.concatenate([self.places, beacons, markers])
        self.known_places = np.concatenate([self.known_places, known])
        self.profile = np.concatenate([self.profile, profile])
        self.pattern = np.concatenate([self.pattern, pattern])
        self.tag_positions_m = np.concatenate([self.tag_positions_m, [position for position, _ in tags]])
        self.tag_ids.extend(tag_id for _, tag_id in tags)
        self._known[key] = rows
        return rows

    def lay_markers(self, group: int, *, whole: bool) -> None:
        """A group of markers (id) has lost one, or has them all again."""
        self._broken = self._broken - {group} if whole else self._broken | {group}
        for (pieces, direction, _train), rows in self._known.items():
            laid = markers_on(self._line, path_of(self._line, pieces, direction), self._broken)
            self.places[rows.markers_first : rows.markers_end] = laid

    def lay_plan(self, slot: int, path_rows: int, plan: NDArray[np.void]) -> int:
        """Lay a plan (rows of PLAN, one a metre of the unit's path) for one stock; no rows: it has none any more.

        Returns where it lies, which `onboard.motion.Motion.follow` takes. To be called between stretches only, with
        what an event has brought. ValueError where it is not as long as the unit's path.
        """
        if plan.size not in (0, path_rows):
            raise ValueError(f"a plan of {plan.size} rows for a path of {path_rows}")
        offset, room = self._plan_room.get(slot, (0, 0))
        if plan.size > room:
            offset = self.plan.size
            self.plan = np.concatenate([self.plan, plan])
            self._plan_room[slot] = (offset, plan.size)
        self.plan[offset : offset + plan.size] = plan
        return offset

    @property
    def track(self) -> PathArrays:
        """The arrays as compiled code takes them."""
        return PathArrays(
            self.profile, self.pattern, self.plan, self.tag_positions_m, self.places, self.known_places
        )

    def pattern_of(self, rows: PathRows) -> NDArray[np.void]:
        """The unit's path database of one path."""
        return self.pattern[rows.offset : rows.offset + rows.rows]
