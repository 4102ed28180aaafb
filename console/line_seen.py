"""What can be known of the line without seeing it: the register as the block manager shows it, where trains were last
heard of, and what people should hear of. It is made from the journal alone, entry by entry.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Final

from console.crossings_seen import CrossingsSeen
from console.forecast import DayForecast
from console.protocol import (
    BidShown,
    EventShown,
    GraphPoint,
    SectionShown,
    SectionState,
    TrainForecast,
    TrainShown,
)
from onboard import notes
from onboard.crossing_notes import CrossingProofLost
from radio.noted import TelegramDropped, TookEffect
from simulation import events
from simulation.setup import Setup
from study.wording.events import EVENT_WORDINGS, event_text
from study.wording.parties import party
from study.wording.phrase import names_of
from wayside import said
from wayside.crossing_said import CrossingUnproven
from wayside.register import ReentryStage

ALARMS: Final = (
    events.Unsafe,
    events.Collision,
    events.StepRefused,
    events.VehicleStruck,
    said.Contradicted,
    said.NoOrderKnown,
    said.PointsUnproven,
    said.NotDone,
    CrossingUnproven,
    CrossingProofLost,
    notes.Mismatch,
    notes.UnitRestarted,
    notes.VehicleUnfit,
)
ASKED_AGAIN: Final = (said.Refused, said.Contradicted, notes.SignOnDenied)  # as often as what it answers


@dataclass(slots=True)
class _Heard:
    """A unit as it was last heard of."""

    train: str = ""
    station: str = ""
    heard_s: float | None = None
    late_s: float | None = None
    due_s: float = inf  # when it is to leave from there or, under way, to come to its next stop


@dataclass(frozen=True, slots=True)
class SeenEvent:
    """An event in words; `truth`: only who sees the line itself knows of it."""

    shown: EventShown
    truth: bool


class LineSeen:
    """The line as its own words tell it; `events` and `graph` only grow."""

    def __init__(self, setup: Setup, forecast: DayForecast | None = None) -> None:
        self._forecast: Final = forecast
        self.crossings: Final = CrossingsSeen(setup.line)
        self._bids: dict[str, BidShown] = {}
        self.events: list[SeenEvent] = []
        self.graph: list[GraphPoint] = []
        self.defined = False
        self.manager_on = True
        self.outages: list[tuple[float, float | None]] = []  # from when until when nothing was defined
        self._begun = False  # the line has been defined once
        self._names: Final = names_of(setup.line)
        self._line, self._timetable = setup.line, setup.timetable
        self._held: dict[str, tuple[str, ...]] = {}  # by unit
        self._answers: dict[tuple[str, str], set[object]] = {}  # since all else, by author and unit
        self._units = {diagram.stock_id: _Heard() for diagram in setup.timetable.diagrams}

    def forecast(self, now_s: float) -> tuple[TrainForecast, ...]:
        """What follows for each train; none where it is not known."""
        return () if self._forecast is None or not self.manager_on else self._forecast.trains(now_s)

    def bids(self, now_s: float) -> tuple[BidShown, ...]:
        """Trains that a dispatcher keeps back."""
        return tuple(bid for bid in self._bids.values() if bid.until_s > now_s)

    @property
    def sections(self) -> tuple[SectionShown, ...]:
        """Every section as the manager shows it, in the order of the line."""
        holders = {section: unit for unit, sections in self._held.items() for section in sections}
        known = self.manager_on
        rest = SectionState.FREE if known and self.defined else SectionState.UNDEFINED
        return tuple(
            SectionShown(id=section, state=SectionState.HELD, unit=holders[section])
            if known and section in holders
            else SectionShown(id=section, state=rest)
            for section in self._line.sections
        )

    def trains(self, now_s: float) -> tuple[TrainShown, ...]:
        """Every unit as it was last heard of; it is late by as much at least as what it is to do next is overdue."""
        return tuple(
            TrainShown(
                unit=unit,
                train=heard.train,
                station=heard.station,
                heard_s=heard.heard_s,
                late_s=max(heard.late_s or 0.0, now_s - heard.due_s) if now_s > heard.due_s else heard.late_s,
                sections=self._held.get(unit, ()),
            )
            for unit, heard in self._units.items()
        )

    def see(self, entry: events.JournalEntry) -> None:
        """An entry was written."""
        self.crossings.see(entry)
        if isinstance(entry.event, TookEffect) and entry.event.receiver == events.MANAGER:
            if (heard := self._units.get(entry.event.source)) is not None:
                heard.heard_s = entry.t_s
            return
        if entry.who == events.MANAGER:
            self._of_manager(entry)
        elif entry.who in self._units:
            self._of_unit(entry.t_s, self._units[entry.who], entry.event)
        match entry.event:
            case events.PowerOff(device_id=device) if device == events.MANAGER:
                self.manager_on, self.defined = False, False
                self._held.clear()
            case events.PowerOn(device_id=device) if device == events.MANAGER:
                self.manager_on = True
            case _:
                pass
        self._note_outage(entry.t_s)
        if self._forecast is not None:
            self._forecast.see(entry, self._held)
        hidden = isinstance(entry.event, TelegramDropped) or self._is_said_again(entry)
        if type(entry.event) in EVENT_WORDINGS and not hidden:
            words = event_text(entry.event, self._names)
            shown = EventShown(
                time_s=entry.t_s,
                who=entry.who,
                who_ja=party(entry.who).in_("ja"),
                text=words.en,
                text_ja=words.in_("ja"),
                alarm=isinstance(entry.event, ALARMS) or _refuses_person(entry),
            )
            # by radio its device says no more than that it is not
            unsaid = isinstance(entry.event, CrossingUnproven)
            of_world = entry.who == events.WORLD and not isinstance(entry.event, events.Acted)
            self.events.append(SeenEvent(shown, of_world or unsaid))

    def _is_said_again(self, entry: events.JournalEntry) -> bool:
        """Whether its author has answered a unit so before, and since then nothing else but such answers."""
        event, key = entry.event, (entry.who, getattr(entry.event, "unit_id", ""))
        if _refuses_person(entry):
            return False
        if not isinstance(event, ASKED_AGAIN):
            if type(event) in EVENT_WORDINGS or isinstance(event, said.Granted):
                self._answers.pop(key, None)
            return False
        mine = self._answers.setdefault(key, set())
        before = event in mine
        mine.add(event)
        return before

    def _note_outage(self, t_s: float) -> None:
        whole = self.defined and self.manager_on
        lasts = bool(self.outages) and self.outages[-1][1] is None
        if self._begun and not whole and not lasts:
            self.outages.append((t_s, None))
        elif whole and lasts:
            self.outages[-1] = (self.outages[-1][0], t_s)
        self._begun = self._begun or whole

    def _of_manager(self, entry: events.JournalEntry) -> None:
        t_s = entry.t_s
        match entry.event:
            case said.Started(epoch=epoch):
                self._held.clear()
                self._bids.clear()
                self.defined = epoch == 1
                self.manager_on = True
            case said.PictureChanged(stage=stage):
                self.defined = stage == ReentryStage.DEFINED.value
            case said.Granted(unit_id=unit, section_ids=sections):
                self._held[unit] = tuple(dict.fromkeys((*self._held.get(unit, ()), *sections)))
            case (
                said.Accepted(unit_id=unit, section_ids=sections)
                | said.ConfirmedByHand(unit_id=unit, section_ids=sections)
            ):
                self._held[unit] = sections
            case said.Freed(unit_id=unit, section_ids=sections):
                self._held[unit] = tuple(s for s in self._held.get(unit, ()) if s not in sections)
            case said.WaitBidden(unit_id=unit, hold_s=hold_s, other_id=other, section_id=section):
                self._bids[unit] = BidShown(unit=unit, until_s=t_s + hold_s, behind=other, section=section)
            case said.WaitOver(unit_id=unit):
                self._bids.pop(unit, None)
            case said.Outside(unit_id=unit):
                self._held.pop(unit, None)
            case _:
                pass

    def _of_unit(self, t_s: float, heard: _Heard, event: object) -> None:
        match event:
            case notes.MissionBegun(train=train) if train != heard.train:
                heard.train, heard.late_s = train, None  # the one before was late, not this one
                calls = self._timetable.trains[train].calls if train in self._timetable.trains else ()
                here = (
                    call.last_s for call in calls if call.station_id == heard.station
                )  # turned short there
                heard.due_s = next(here, calls[0].last_s if calls else inf)
            case notes.Arrived(station=station):
                self._called(t_s, heard, station, leaves=False)
            case notes.Departs(station=station):
                self._called(t_s, heard, station, leaves=True)
            case _:
                pass

    def _called(self, t_s: float, heard: _Heard, station: str, *, leaves: bool) -> None:
        """A train has arrived or leaves: how late that is, what is due next, and a point of the graph."""
        heard.station, heard.due_s = station, inf
        train = self._timetable.trains.get(heard.train)
        if train is None or station not in self._line.stations:
            return
        at = next((i for i, call in enumerate(train.calls) if call.station_id == station), len(train.calls))
        for call in train.calls[at : at + 1]:
            heard.late_s = t_s - (call.last_s if leaves else call.first_s)
            stops = (onward.first_s for onward in train.calls[at + 1 :] if onward.stops)
            due_s = next(stops, None) if leaves else call.departure_s
            heard.due_s = inf if due_s is None else due_s
        at_m = self._line.stations[station].position_m
        self.graph.append(GraphPoint(train=heard.train, time_s=t_s, at_m=at_m))


def _refuses_person(entry: events.JournalEntry) -> bool:
    """Whether the manager has refused what somebody entered."""
    event = entry.event
    return entry.who == events.MANAGER and isinstance(event, said.Refused) and ": " in event.why
