"""The plan of one train number as the on-board machines see it: joints, marks and tags in order, no metres.

Fixed data of a duty (固定データ), made once from the mission and kept outside every state, so that a state stays small
and two trains on the same plan differ only in their states. Joint `i` is where span `i` begins; the joint behind the
last span is the end of the path. `onboard.motion` turns metres into joints and back.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import Final

import msgspec

from network.model import Position, SectionKind, TagPurpose
from onboard.mission import Mission

ARRIVED_ON_SIGHT_WITHIN_M: Final = 6.0  # a mark reached by the crew's eye
CLEAR_OF_TAG_M: Final = 0.5  # assumed: beyond what a reader's field leaves open, with the rear past a joint


class PointsNeeded(msgspec.Struct, frozen=True, order=True):
    """A set of points as the path needs it."""

    points_id: str
    position: Position
    section_id: str
    terminal_id: str


class Span(msgspec.Struct, frozen=True):
    """One section on the path; `piece` and `kilometrage_m` say where it begins, for people."""

    section_id: str
    kind: SectionKind
    points: tuple[PointsNeeded, ...]
    piece: str
    kilometrage_m: float


class PlanLeg(msgspec.Struct, frozen=True):
    """A route of the plan: from a track to the next one; `entry`: where it needs leave to come in (`Route.entry`)."""

    route_id: str
    from_section: str
    section_ids: tuple[str, ...]
    entry: tuple[str, ...] = ()

    @property
    def to_enter(self) -> tuple[str, ...]:
        """What leave to come in is for: those points, and the track behind them."""
        return self.section_ids[-len(self.entry) - 1 :] if self.entry else ()


class PlanStop(msgspec.Struct, frozen=True):
    """A place where the train stops: in which span, when; `clear`: spans surely behind a train at this mark, by eye.

    `by_eye`: no tag up to the mark proves all that to be behind it, so that the driver must confirm the arrival.
    """

    place: str  # the station, or the section where the train leaves the line
    is_station: bool
    span: int
    clear: int
    arrival_s: float | None
    departure_s: float | None
    by_eye: bool = False
    passengers: bool = True  # they get on and off


class PlanTag(msgspec.Struct, frozen=True):
    """A tag of the path; `ahead`: the first span that begins beyond it; `clear`: spans behind a train that reads it."""

    tag_id: int
    purpose: TagPurpose
    ahead: int
    clear: int = 0


class DutyPlan(msgspec.Struct, frozen=True):
    """All of it; `end_*` say where the path ends."""

    number: str
    direction: str
    spans: tuple[Span, ...]
    legs: tuple[PlanLeg, ...]
    stops: tuple[PlanStop, ...]
    tags: tuple[PlanTag, ...]
    end_piece: str
    end_kilometrage_m: float
    enters: bool  # the first section is a portal
    overlaps: bool = False  # points may need leave

    def leg_beyond(self, section_id: str) -> PlanLeg | None:
        """The route that begins in a section; None where the plan ends there, or on open line."""
        return next((leg for leg in self.legs if leg.from_section == section_id), None)

    def leg_at(self, span: int) -> PlanLeg | None:
        """The route that begins in a span, or else the one that leads through it; None at the plan's end."""
        section_id = self.spans[span].section_id
        through = next((leg for leg in self.legs if section_id in leg.section_ids[:-1]), None)
        return self.leg_beyond(section_id) or through

    def joint(self, index: int) -> tuple[str, float]:
        """Piece and kilometrage (m) of a joint."""
        if index < len(self.spans):
            return self.spans[index].piece, self.spans[index].kilometrage_m
        return self.end_piece, self.end_kilometrage_m

    def departure_points(self, from_section: str) -> tuple[PointsNeeded, ...]:
        """Points between a track and the open line beyond it: thrown as soon as the route is held."""
        at = next(i for i, span in enumerate(self.spans) if span.section_id == from_section)
        return self._points_up_to_other(at + 1)

    def _points_up_to_other(self, first: int) -> tuple[PointsNeeded, ...]:
        found: list[PointsNeeded] = []
        for span in self.spans[first:]:
            if span.kind is not SectionKind.POINTS:
                break
            found.extend(span.points)
        return tuple(found)

    def arrival_points(self, tag: PlanTag) -> tuple[PointsNeeded, ...]:
        """Points ahead of a train on the open line up to the next track: thrown at the approach tag (④)."""
        ahead = tag.ahead
        while ahead < len(self.spans) and self.spans[ahead].kind is SectionKind.BETWEEN:
            ahead += 1
        return self._points_up_to_other(ahead)

    def track_ahead(self, tag: PlanTag) -> Span | None:
        """The next track that begins beyond a tag."""
        return next((s for s in self.spans[tag.ahead :] if s.kind is SectionKind.TRACK), None)

    def track_behind_joint(self, tag: PlanTag) -> Span | None:
        """The track that begins where the open line of a tag ends, without points between (no ④ stands before it)."""
        here, ahead = self.spans[max(tag.ahead - 1, 0)], self.spans[tag.ahead : tag.ahead + 1]
        if here.kind is not SectionKind.BETWEEN or not ahead or ahead[0].kind is not SectionKind.TRACK:
            return None
        return ahead[0]

    def calls_at(self, section_id: str) -> bool:
        """Whether the train stops in a section."""
        return any(self.spans[stop.span].section_id == section_id for stop in self.stops)


def plan_of(mission: Mission, length_m: float) -> DutyPlan:
    """The plan of a mission for a train of this length."""
    path = mission.path
    spans: list[Span] = []
    for span in mission.spans:
        piece, kilometrage_m = path.locate(span.start_m)
        points = tuple(
            PointsNeeded(points_id, position, span.section_id, terminal_id)
            for points_id, position, terminal_id in span.points
        )
        spans.append(Span(span.section_id, span.kind, points, piece, kilometrage_m))
    starts_m = [span.start_m for span in mission.spans]  # one behind the other along the path
    ends_m = [span.end_m for span in mission.spans]
    tags = tuple(
        PlanTag(
            tag.tag_id,
            tag.purpose,
            bisect_right(starts_m, tag.position_m),
            bisect_right(ends_m, tag.position_m - length_m - CLEAR_OF_TAG_M),
        )
        for tag in mission.tags
    )
    stops: list[PlanStop] = []
    for target in mission.targets:
        rear_m = target.mark_m - ARRIVED_ON_SIGHT_WITHIN_M - length_m
        at = mission.span_index(target.section_id)
        # at a halt on open line nothing is released
        on_track = mission.spans[at].kind is not SectionKind.BETWEEN
        clear = bisect_right(ends_m, rear_m) if on_track else 0
        read = zip(mission.tags, tags, strict=True)
        by_tag = max((tag.clear for laid, tag in read if laid.position_m <= target.mark_m), default=0)
        stops.append(
            PlanStop(
                target.place_id,
                target.station_id is not None,
                at,
                clear,
                target.arrival_s,
                target.departure_s,
                by_eye=by_tag < clear,
                passengers=target.passengers,
            )
        )
    end_piece, end_m = path.locate(mission.spans[-1].end_m)
    return DutyPlan(
        mission.number,
        mission.direction.name.lower(),
        tuple(spans),
        tuple(PlanLeg(r.id, r.from_section, r.section_ids, r.entry) for r in mission.routes),
        tuple(stops),
        tags,
        end_piece,
        end_m,
        enters=mission.spans[0].kind is SectionKind.PORTAL,
        overlaps=mission.overlaps,
    )


NO_PLAN: Final = DutyPlan("", "", (), (), (), (), "", 0.0, enters=False)
