"""What one unit has said of itself so far: its duty, its requests, its stop limit, what is wrong with it.

Made again from its notes in the journal, in their order, and never asked of the unit: a run directory is enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, Final, get_args

from network.files.crossings import least_closed_s
from network.model import Line
from onboard import crossing_notes, notes
from radio.noted import Lost, LostWhere, Noted, Sent, TookEffect
from simulation import events
from simulation.clock import Clock
from simulation.events import MANAGER, JournalEntry
from simulation.world.roster import Duty, cut_at, ordered_by
from study.measures.register_holds import is_of_crossing
from study.record.wait import AwaitedRequest
from wayside import said


class DutyStage(Enum):
    """Where a unit is in its duty."""

    NOTHING = "nothing"
    SIGNING_ON = "signing on"
    STANDING = "standing"
    RUNNING = "running"
    ON_SIGHT = "on sight"
    FINISHED = "finished"
    SIGNING_OFF = "signing off"
    GONE = "gone"


EMERGENCY_LEVEL: Final = 2
_ASKS: Final[Mapping[str, AwaitedRequest]] = {
    "SignOn": AwaitedRequest.SIGN_ON,
    "SignOff": AwaitedRequest.SIGN_OFF,
    "RouteRequest": AwaitedRequest.ROUTE,
    "HoldingReport": AwaitedRequest.REPORT,
    "NextTrainReport": AwaitedRequest.REPORT,
}


@dataclass(slots=True)
class WaitingRequest:
    """A request that is open: when it was first sent, s, its correlation, and why it was refused (empty: not yet)."""

    since_s: float
    correlation: int | None
    refusal: str = ""


@dataclass(frozen=True, slots=True)
class CrossingWait:
    """A level crossing that was asked: since and from when proven, s, and why its proof was lost."""

    since_s: float
    proven_s: float = math.inf
    lost: str = ""


@dataclass(slots=True)
class StockView:
    """The unit as its notes show it. `at`: the stop where it stands or that it left last; `ready_s`: the dwell ends."""

    unit: str
    duties: Sequence[Duty]  # as orders have changed them so far
    dwell_s: float
    line: Line
    length_m: float
    train: str = ""
    duty: Duty | None = None
    doing: DutyStage = DutyStage.NOTHING
    at: int = 0
    ready_s: float = 0.0
    dwells: bool = False  # for passengers; not so where it stood before its train began
    departed: bool = False
    signed_on: bool = False
    signed_on_s: float = 0.0
    requests: dict[AwaitedRequest, WaitingRequest] = field(
        default_factory=dict[AwaitedRequest, WaitingRequest]
    )
    limit_before: str | None = None
    limit_why: str = "no mission"
    limit_at: tuple[str, float] | None = None  # piece, kilometrage in m
    commanded_s: dict[str, float] = field(default_factory=dict[str, float])  # by terminal
    proven: set[str] = field(default_factory=set[str])
    points_refused: dict[str, str] = field(default_factory=dict[str, str])
    crew_waits_at: str = ""
    crossings: dict[str, CrossingWait] = field(default_factory=dict[str, CrossingWait])
    unfit: str = ""
    doors_until_s: float = -math.inf  # held open by people until then
    unable: str = ""  # why it may not leave its stop
    emergency: bool = False
    mismatch: str = ""
    powered: bool = True
    by_hand: bool = False  # its unit is cut out, and people let it go
    numberless: bool = False  # it has booted, and its crew has not entered the train number yet
    frozen: bool = False
    set_back: bool = False
    cable_cut: bool = False  # what it said last was lost in the cable
    clocks: dict[str, tuple[float, dict[str, float]]] = field(
        default_factory=dict[str, tuple[float, dict[str, float]]]
    )

    @property
    def next_duty(self) -> Duty | None:
        """The duty after the present one; the first where none has begun."""
        if self.duty is None:
            return self.duties[0] if self.duties else None
        following = self.duties.index(self.duty) + 1
        return self.duties[following] if following < len(self.duties) else None

    def shown_at_s(self, planned_s: float) -> float:
        """True time, s, at which the unit's own clock shows a time of the plan."""
        clock = Clock()
        for since_s, wrong in self.clocks.values():
            clock = clock.wrong(wrong.get("offset_s", 0.0), wrong.get("drift_ppm", 0.0) * 1e-6, since_s)
        return clock.true_s(planned_s)

    def crossing_ahead(self, here: tuple[str, float] | None, t_s: float) -> tuple[str, float]:
        """The first level crossing on its way that was asked and is not closed for long enough, and until when, s."""
        path = None if self.duty is None else self.duty.mission.path
        if path is None or here is None or here[0] not in path:
            return "", math.inf
        found: list[tuple[float, str, float]] = []
        for crossing_id, asked in self.crossings.items():
            crossing = self.line.crossings[crossing_id]
            until_s = asked.proven_s + least_closed_s(crossing)
            if crossing.piece_id in path and t_s < until_s:
                found.append((path.to_road_m(crossing) - path.to_path_m(*here), crossing_id, until_s))
        _, crossing_id, until_s = min((one for one in found if one[0] > 0.0), default=(0.0, "", math.inf))
        return crossing_id, until_s

    def take(self, entry: JournalEntry) -> None:
        """A line of the journal that the unit wrote, or that names it."""
        reader = _READERS.get(type(entry.event))
        if reader is not None:
            reader(self, entry.t_s, entry.event)

    def duties_after(self, entries: Sequence[JournalEntry]) -> Sequence[Duty]:
        """The duties that it has run, or has yet to run, after these lines of the journal."""
        if any(isinstance(entry.event, notes.EndedEarly) for entry in entries):
            for entry in entries:
                self.take(entry)
        return self.duties

    def schedule(self, t_s: float, *, dwells: bool) -> None:
        """From when it may leave the stop at which it stands, its departure apart."""
        self.ready_s = t_s + (self.dwell_s if dwells else 0.0)
        self.dwells, self.departed = dwells, False


def _is(view: StockView, train: str) -> None:
    view.train = train
    view.duty = next((duty for duty in view.duties if duty.train.number == train), None)


def _mission(view: StockView, t_s: float, event: notes.MissionBegun) -> None:
    _is(view, event.train)
    view.numberless = False
    view.at = 0
    view.doing = DutyStage.STANDING if view.signed_on else DutyStage.SIGNING_ON
    view.schedule(t_s, dwells=False)
    view.limit_before, view.limit_why, view.limit_at = None, "no mission", None
    view.crew_waits_at, view.set_back, view.unable = "", False, ""
    view.proven.clear()
    view.points_refused.clear()
    view.commanded_s.clear()


def _restarted(view: StockView, t_s: float, _event: notes.UnitRestarted) -> None:
    view.doing, view.signed_on, view.mismatch = DutyStage.ON_SIGHT, False, ""
    view.emergency, view.unable = True, ""
    view.requests.clear()
    view.crossings.clear()
    view.ready_s = t_s


def _arrived(view: StockView, t_s: float, event: notes.Arrived) -> None:
    targets = () if view.duty is None else view.duty.mission.targets
    places = [target.place_id for target in targets]
    view.at = next(
        (i for i in range(view.at, len(places)) if places[i] == event.station and (i > view.at or i == 0)),
        view.at,
    )
    view.schedule(t_s, dwells=bool(targets) and targets[view.at].passengers)
    if view.doing is DutyStage.RUNNING:
        view.doing = DutyStage.STANDING


def _resumed(view: StockView, _t_s: float, event: notes.Resumed) -> None:
    view.at = event.next_target - 1
    view.doing = DutyStage.RUNNING if view.departed else DutyStage.STANDING
    view.crew_waits_at = ""


def _departs(view: StockView, _t_s: float, _event: notes.Departs) -> None:
    view.doing, view.departed = DutyStage.RUNNING, True


def _mission_done(view: StockView, _t_s: float, event: notes.MissionDone) -> None:
    _is(view, event.train)  # of one that was driven by hand its unit said nothing as it began
    leaves = view.duty is not None and view.duty.leaves
    view.doing = DutyStage.SIGNING_OFF if leaves else DutyStage.FINISHED


def _lost_position(view: StockView, _t_s: float, _event: notes.PositionFault) -> None:
    view.emergency, view.unable = True, ""
    if view.doing in (DutyStage.STANDING, DutyStage.RUNNING):
        view.doing = DutyStage.ON_SIGHT


def _limit(view: StockView, _t_s: float, event: notes.LimitSet) -> None:
    view.limit_before, view.limit_why = event.before, event.why
    view.limit_at = event.piece_id, event.kilometrage_m


def _intervenes(view: StockView, _t_s: float, event: notes.Intervention) -> None:
    if event.level == EMERGENCY_LEVEL:
        view.emergency = True


def _unfit(view: StockView, _t_s: float, event: notes.VehicleUnfit) -> None:
    view.unfit = event.why
    if view.doing in (DutyStage.RUNNING, DutyStage.ON_SIGHT):
        view.emergency = True


def _doors(view: StockView, _t_s: float, event: events.DoorsHeld) -> None:
    view.doors_until_s = event.until_s


def _unable(view: StockView, _t_s: float, event: notes.UnableToLeave) -> None:
    view.unable = event.why


def _mismatch(view: StockView, _t_s: float, event: notes.Mismatch) -> None:
    view.mismatch, view.emergency = event.why, True


def _sent(view: StockView, t_s: float, event: Sent) -> None:
    if event.source != view.unit or event.kind is None:
        return
    asked = _ASKS.get(event.kind)
    if asked is not None:
        known = view.requests.get(asked)
        if known is None or (asked is AwaitedRequest.REPORT and known.correlation != event.correlation):
            view.requests[asked] = WaitingRequest(t_s, event.correlation)
        else:  # what was refused is asked again as a new request: it is open all the same
            known.correlation = event.correlation
        if asked is AwaitedRequest.ROUTE:
            view.set_back = False
    elif event.kind == "PointsCommand":
        view.commanded_s.setdefault(event.receiver, t_s)


def _took_effect(view: StockView, _t_s: float, event: TookEffect) -> None:
    view.cable_cut = False
    request = view.requests.get(AwaitedRequest.REPORT)
    confirmed = event.receiver == view.unit and event.kind == "HoldingConfirmed"
    if confirmed and request is not None and request.correlation == event.correlation and not view.mismatch:
        del view.requests[AwaitedRequest.REPORT]  # sent once more it is open again


def _signed_on(view: StockView, t_s: float, _event: notes.SignedOn) -> None:
    view.signed_on, view.signed_on_s, view.mismatch = True, t_s, ""
    view.requests.pop(AwaitedRequest.SIGN_ON, None)
    if view.doing is DutyStage.SIGNING_ON:
        view.doing = DutyStage.STANDING


def _gone(view: StockView, _t_s: float, _event: notes.SignedOff | events.Left) -> None:
    """Signed off, or off the line without a word of its unit: hauled away."""
    view.signed_on, view.doing = False, DutyStage.GONE
    view.requests.clear()


def _route_held(view: StockView, _t_s: float, _event: notes.RouteHeld) -> None:
    view.requests.pop(AwaitedRequest.ROUTE, None)
    view.commanded_s.clear()


def _goes_by(view: StockView, change: Callable[..., Sequence[Duty]], *order: object) -> None:
    """By its duties as an order changes them from its train on; what it asked for it asks for no more."""
    view.requests.pop(AwaitedRequest.ROUTE, None)
    if view.duty is not None:
        at = view.duties.index(view.duty)
        view.duties = change(view.line, view.duties, at, *order, view.length_m)
        view.duty = view.duties[at]


def _way_changed(view: StockView, _t_s: float, event: notes.WayChanged) -> None:
    _goes_by(view, ordered_by, event.route_id, event.instead)


def _ended_early(view: StockView, _t_s: float, event: notes.EndedEarly) -> None:
    _goes_by(view, cut_at, view.at, event.next_train)


def _refused(asked: AwaitedRequest) -> Callable[[StockView, float, Any], None]:
    def refused(
        view: StockView, t_s: float, event: notes.SignOnDenied | notes.SignOffDenied | notes.RouteDenied
    ) -> None:
        request = view.requests.setdefault(asked, WaitingRequest(t_s, None))
        request.refusal = event.why

    return refused


def _gave_back(view: StockView, t_s: float, _event: notes.GaveBack) -> None:
    view.requests.pop(AwaitedRequest.ROUTE, None)
    view.set_back, view.ready_s = True, max(view.ready_s, t_s)
    view.proven.clear()


def _proven(view: StockView, _t_s: float, event: notes.Proven) -> None:
    view.proven.add(event.points_id)
    view.points_refused.pop(event.points_id, None)
    view.crew_waits_at = ""


def _proof_dropped(view: StockView, _t_s: float, event: notes.ProofDropped) -> None:
    view.proven.discard(event.points_id)


def _throw_denied(view: StockView, _t_s: float, event: notes.ThrowDenied) -> None:
    view.points_refused[event.points_id] = event.why


def _crossing(view: StockView, t_s: float, event: crossing_notes.CrossingNote) -> None:
    """Asked, it has to prove closed, or the driver to get leave."""
    match event:
        case crossing_notes.CrossingAsked():
            view.crossings[event.crossing_id] = CrossingWait(t_s)
        case crossing_notes.CrossingHeardClosed() | crossing_notes.CrossingHeardClear():
            asked = view.crossings.get(event.crossing_id, CrossingWait(t_s))
            view.crossings[event.crossing_id] = replace(asked, proven_s=t_s)
        case crossing_notes.CrossingProofLost():
            view.crossings[event.crossing_id] = CrossingWait(t_s, lost=event.why.value)
        case _:
            view.crossings.pop(event.crossing_id, None)


def _fault(view: StockView, t_s: float, event: events.FaultBegan) -> None:
    if event.kind == "frozen":
        view.frozen = True
    elif event.kind == "clock":
        numbers: dict[str, float] = {
            name: value for name, value in event.parameters.items() if not isinstance(value, str)
        }
        view.clocks[repr(sorted(event.parameters.items()))] = t_s, numbers


def _fault_over(view: StockView, _t_s: float, event: events.FaultOver) -> None:
    if event.kind == "frozen":
        view.frozen = False
    elif event.kind == "clock":
        view.clocks.pop(repr(sorted(event.parameters.items())), None)


def _set(**values: object) -> Callable[[StockView, float, Any], None]:
    def put(view: StockView, _t_s: float, _event: Noted) -> None:
        for name, value in values.items():
            setattr(view, name, value)

    return put


_READERS: Final[Mapping[type[Noted], Callable[[StockView, float, Any], None]]] = {
    notes.MissionBegun: _mission,
    notes.MissionDone: _mission_done,
    notes.UnitRestarted: _restarted,
    notes.Resumed: _resumed,
    notes.Departs: _departs,
    notes.Arrived: _arrived,
    notes.PositionFault: _lost_position,
    notes.Intervention: _intervenes,
    notes.EmergencyReleased: _set(emergency=False),
    notes.VehicleUnfit: _unfit,
    events.DoorsHeld: _doors,
    notes.VehicleFit: _set(unfit=""),
    notes.UnableToLeave: _unable,
    notes.AbleToLeave: _set(unable=""),
    notes.Mismatch: _mismatch,
    notes.Agreed: _set(mismatch=""),
    notes.SignedOn: _signed_on,
    notes.SignOnDenied: _refused(AwaitedRequest.SIGN_ON),
    notes.SignedOff: _gone,
    events.Left: _gone,
    notes.SignOffDenied: _refused(AwaitedRequest.SIGN_OFF),
    notes.RouteHeld: _route_held,
    notes.RouteDenied: _refused(AwaitedRequest.ROUTE),
    notes.GaveBack: _gave_back,
    notes.WayChanged: _way_changed,
    notes.EndedEarly: _ended_early,
    notes.LimitSet: _limit,
    notes.Proven: _proven,
    notes.ProofDropped: _proof_dropped,
    notes.ThrowDenied: _throw_denied,
    notes.CrewWaitsAtPoints: lambda view, _t_s, event: setattr(view, "crew_waits_at", event.points_id),
    notes.CrewCheckedPoints: _set(crew_waits_at=""),
    **dict.fromkeys(get_args(crossing_notes.CrossingNote), _crossing),
    Sent: _sent,
    Lost: _set(cable_cut=True),
    TookEffect: _took_effect,
    events.PowerOff: _set(powered=False, numberless=False),
    # An emergency is that of the unit that has restarted: who comes by a portal has none.
    events.PowerOn: _set(powered=True, emergency=False, numberless=True),
    events.CutOut: _set(by_hand=True),
    events.CutIn: _set(by_hand=False),
    events.FaultBegan: _fault,
    events.FaultOver: _fault_over,
}


def subject_of(entry: JournalEntry) -> str:
    """The unit whose view an entry may change: the party that it names, or its author."""
    match entry.event:
        case events.PowerOff(device_id=device) | events.PowerOn(device_id=device):
            return device
        case events.FaultBegan(target=target) | events.FaultOver(target=target):
            return target
        case TookEffect(receiver=receiver):
            return receiver
        case (
            events.CutOut(unit_id=unit)
            | events.CutIn(unit_id=unit)
            | events.DoorsHeld(unit_id=unit)
            | events.Left(unit_id=unit)
            | Lost(where=LostWhere.CABLE, source=str() as unit)
        ):
            return unit
        case said.Refused(unit_id=unit) if entry.who == MANAGER:
            return unit
        case _:
            return entry.who


def by_unit(entries: Iterable[JournalEntry], into: dict[str, list[JournalEntry]]) -> Iterator[JournalEntry]:
    """Passes entries on, and sorts them by the unit whose view they may change."""
    for entry in entries:
        sections = not is_of_crossing(entry.event)
        if sections or isinstance(entry.event, crossing_notes.CrossingNote):
            into[subject_of(entry)].append(entry)
        if sections:
            yield entry
