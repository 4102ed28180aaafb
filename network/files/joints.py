"""Join pieces end to end: from the names in `[[points]]` and `[[joints]]` to the nodes of the graph."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from network.errors import InputError
from network.files.line_schema import DIRECTIONS, PointsTable
from network.files.toml_input import one_of
from network.model import Direction, PointsLeg

MEET_TOLERANCE_M: Final = 0.001
_SIDE: Final = {Direction.DOWN: "high", Direction.UP: "low"}


@dataclass(frozen=True, slots=True)
class PieceDraft:
    """A piece before its nodes are known; `key` is the table it comes from, `faces` that of its points."""

    id: str
    key: str
    section_id: str
    alignment_id: str
    from_m: float
    to_m: float
    offset_m: float | None
    points_id: str | None = None
    leg: PointsLeg | None = None
    faces: Direction | None = None

    @property
    def toe_end(self) -> Direction | None:
        """The end at the toe of points: DOWN is the high end, UP the low end."""
        if self.faces is None:
            return None
        return self.faces if self.leg is PointsLeg.STEM else self.faces.opposite

    def end_m(self, end: Direction) -> float:
        """Kilometrage (m) of the high (DOWN) or low (UP) end."""
        return self.to_m if end is Direction.DOWN else self.from_m


End = tuple[str, Direction]  # a piece and its high (DOWN) or low (UP) end


class Joiner:
    """Which end meets which. Every method raises InputError for a joint that cannot be."""

    def __init__(self, file: str, drafts: Mapping[str, PieceDraft], points_sections: set[str]) -> None:
        self._file = file
        self._drafts = drafts
        self._points_sections = points_sections
        self._mates: dict[End, End] = {}
        self._points: dict[str, PointsTable] = {}

    def add_joint(self, key: str, low: str, high: str) -> None:
        """Join the high end of `low` to the low end of `high`."""
        self._find(f"{key}.low", low)
        self._find(f"{key}.high", high)
        self._join(f"{key}.high", (low, Direction.DOWN), (high, Direction.UP))

    def add_points(self, key: str, points: PointsTable) -> None:
        """Join the three ends of points to the neighbours they name."""
        ends = {
            PointsLeg.STEM: points.stem,
            PointsLeg.NORMAL: points.normal,
            PointsLeg.REVERSE: points.reverse,
        }
        faces = DIRECTIONS[points.faces]
        for leg, name in ends.items():
            self._find(f"{key}.{leg.value}", name)
        self._check_sides(key, points, ends)
        for leg, name in ends.items():
            side = faces.opposite if leg is PointsLeg.STEM else faces
            self._join(f"{key}.{leg.value}", (f"{points.id}.{leg.value}", side), (name, side.opposite))
        self._points[points.id] = points

    def node_of(self, draft: PieceDraft, end: Direction) -> str:
        """Node at an end: the points' id at a toe, `low+high` at a joint, with an empty side at a free end.

        Ids cannot contain the plus sign, so these names are unique.
        """
        if draft.points_id is not None and draft.toe_end is end:
            return draft.points_id
        mate = self._mates.get((draft.id, end), ("", end.opposite))
        return f"{draft.id}+{mate[0]}" if end is Direction.DOWN else f"{mate[0]}+{draft.id}"

    def offset_of(self, draft: PieceDraft) -> float:
        """Lateral offset (m) of a piece, of a leg at its outer end; call when all joints are made."""
        if draft.points_id is None or draft.toe_end is None:
            return draft.offset_m or 0.0
        if draft.leg is PointsLeg.STEM:
            return self._points_offset_m(draft.points_id, ())
        mate = self._drafts[self._mates[draft.id, draft.toe_end.opposite][0]]
        if mate.points_id is not None:
            return self._points_offset_m(mate.points_id, ())
        return mate.offset_m or 0.0

    def _points_offset_m(self, points_id: str, asking: tuple[str, ...]) -> float:
        """Offset of the toe: as given, else that of what lies before the stem; 0 at a circle of points."""
        points = self._points[points_id]
        if points.offset_m is not None:
            return points.offset_m
        before = self._drafts[points.stem]
        if before.points_id is None:
            return before.offset_m or 0.0
        if points_id in asking:
            return 0.0
        return self._points_offset_m(before.points_id, (*asking, points_id))

    def _find(self, key: str, name: str) -> PieceDraft:
        if name in self._drafts:
            return self._drafts[name]
        if name in self._points_sections:
            ours = [d.id for d in self._drafts.values() if d.section_id == name]
            raise InputError(self._file, key, name, f"the piece of the points section, {one_of(ours, name)}")
        raise InputError(
            self._file, key, name, f"a section or `<points id>.<leg>`, {one_of(self._drafts, name)}"
        )

    def _check_sides(self, key: str, points: PointsTable, ends: Mapping[PointsLeg, str]) -> None:
        """A neighbour whose middle lies on the wrong side of the toe: either `faces` or the name is wrong."""
        faces = DIRECTIONS[points.faces]
        wrong: list[tuple[PointsLeg, str, Direction]] = []
        for leg, name in ends.items():
            own, mate = self._drafts[f"{points.id}.{leg.value}"], self._drafts[name]
            side = faces.opposite if leg is PointsLeg.STEM else faces
            toe_m = own.end_m(side.opposite)
            beyond_m = ((mate.from_m + mate.to_m) / 2 - toe_m) * side
            if mate.toe_end is side.opposite or (mate.alignment_id == own.alignment_id and beyond_m < 0):
                wrong.append((leg, name, side))
        if len(wrong) == len(ends):
            other = "up" if faces is Direction.DOWN else "down"
            expected = f"{other!r}: stem and legs lead to sections on the wrong side of the toe"
            raise InputError(self._file, f"{key}.faces", points.faces, expected)
        for leg, name, side in wrong:
            expected = f"a piece with a free end on the {_SIDE[side]} side of points that face {points.faces}"
            raise InputError(self._file, f"{key}.{leg.value}", name, expected)

    def _join(self, key: str, ours: End, theirs: End) -> None:
        for name, end in (ours, theirs):
            if self._drafts[name].toe_end is end:
                expected = f"a free end; the {_SIDE[end]} end of {name} is at its toe"
                raise InputError(self._file, key, theirs[0], expected)
        if self._mates.get(ours, theirs) != theirs or self._mates.get(theirs, ours) != ours:
            taken, mate = (ours, self._mates[ours]) if ours in self._mates else (theirs, self._mates[theirs])
            expected = f"an end that is free: the {_SIDE[taken[1]]} end of {taken[0]} is joined to {mate[0]}"
            raise InputError(self._file, key, theirs[0], expected)
        own, mate_ = self._drafts[ours[0]], self._drafts[theirs[0]]
        own_m, mate_m = own.end_m(ours[1]), mate_.end_m(theirs[1])
        if own.alignment_id == mate_.alignment_id and abs(own_m - mate_m) > MEET_TOLERANCE_M:
            expected = (
                f"an end at {own_m / 1000:.6g} km, where {own.id} ends; "
                f"the {_SIDE[theirs[1]]} end of {mate_.id} is at {mate_m / 1000:.6g} km"
            )
            raise InputError(self._file, key, theirs[0], expected)
        self._mates[ours] = theirs
        self._mates[theirs] = ours
