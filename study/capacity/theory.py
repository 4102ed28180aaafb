"""Blocking times of the planned day from running times alone, without a run (Sperrzeiten, 閉そく占有時分).

`occupations(setup)` is the day as units do it (`AS_UNITS`): a route is asked for `request_lead_s` before the departure,
or at the approach tag of a track that the train runs through; its departure points are thrown at once, its arrival
points at the approach tag (④); what lies behind is given back at the arrival tag (①), when the safe rear has left it.
`Theory.of_day` is the same of any journeys, wherever they are moved to, by any rules: with `MINIMAL` a way is set as
late as the train can still run unhindered (blocking time theory: Pachl, Railway Operation and Control).

What comes from where: telegrams `links` (air, repeats), points the line file, running `driven` (the units' own
prediction), bounds of the position `clearing` (`[unit]`, tags of the line), people `[operation]` and the timetable,
pantographs the line file. Trains do not hinder one another: where they would, `conflicts_of` says so.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from network.errors import InputError
from network.graph import overlap_id, overlaps_coming_in, overlaps_going_out
from network.model import Position
from onboard.reach import charger_at
from simulation.people import Pause
from simulation.setup import Setup
from simulation.world.charge_control import READY_S, WORTH_S
from simulation.world.roster import begins_s
from study.capacity.clearing import ReleaseTimes
from study.capacity.driven import StockDriving, driving_of
from study.capacity.journey import TrainJourney
from study.capacity.links import Links
from study.capacity.occupation import Occupation, OccupationPart
from study.capacity.passage import PassageStand, SectionPassage, occupation_of, setting_out
from study.capacity.rules import AS_UNITS, Rules
from study.capacity.setting import Setting, SetUp
from study.feasibility.planned import PlannedDay, planned_day


def occupations(setup: Setup, rules: Rules = AS_UNITS) -> tuple[Occupation, ...]:
    """The blocking times of the whole planned day, in order of their begin."""
    theory = Theory(setup, rules)
    return theory.of_day(theory.journeys())


class Theory:
    """The theory of one setup by one set of rules. Journeys are made once; they may then be moved and joined anew."""

    def __init__(self, setup: Setup, rules: Rules = AS_UNITS) -> None:
        self.setup: Final = setup
        self.rules: Final = rules
        self.links: Final = Links.of(setup.radio_on_average)
        self._day: Final[PlannedDay] = planned_day(setup)
        self._driving: Final[dict[str, StockDriving]] = {
            stock_id: driving_of(setup, stock_id, rules, self.links) for stock_id in self._day.trains
        }
        self.opens_s: Final = begins_s(train.duty for train in self._day.all())

    def journeys(self) -> dict[str, tuple[TrainJourney, ...]]:
        """The journeys of each stock as planned, in order. Points are set as the order of the day has them.

        Raises InputError for a train with one call.
        """
        found = self._journeys(frozenset())
        for journey in (journey for run in found.values() for journey in run):
            if len(journey.stays) < 2:
                raise InputError(
                    self.setup.name, "timetable", journey.number, "a train with two calls or more"
                )
        if self.rules.throws:
            return found
        return self._journeys(self._lie_right(found))

    def of_day(self, journeys: Mapping[str, Sequence[TrainJourney]]) -> tuple[Occupation, ...]:
        """The occupations of all stocks; the day ends with the last journey."""
        ends_s = max((self.over_s(j) for run in journeys.values() for j in run), default=self.opens_s)
        lie_right = frozenset[tuple[str, str]]() if self.rules.throws else self._lie_right(journeys)
        found = [
            occupation_of(passage, ends_s)
            for stock_id, run in journeys.items()
            for passage in self.passages(stock_id, run, lie_right)
        ]
        return tuple(sorted(found, key=lambda o: (o.begin_s, o.section_id)))

    def setting(self, stock_id: str, lie_right: frozenset[tuple[str, str]] = frozenset()) -> Setting:
        """How the ways of a stock are set."""
        driving = self._driving[stock_id]
        return Setting(
            self.rules,
            self.links,
            self.setup.line.points,
            driving.clearing,
            driving.room,
            lie_right,
            parts=self.setup.grants_parts,
        )

    def passages(
        self,
        stock_id: str,
        journeys: Sequence[TrainJourney],
        lie_right: frozenset[tuple[str, str]] = frozenset(),
    ) -> tuple[SectionPassage, ...]:
        """The moments of every section that journeys take which one stock runs one after another, in order.

        Where the first begins on a track it is the stock's from then on, where the last ends until then.
        """
        setting = self.setting(stock_id, lie_right)
        set_ups = [setting.set_ups(journey) for journey in journeys]
        standing = tuple(self._standing(stock_id, journeys, set_ups))
        found: list[SectionPassage] = []
        for journey, own in zip(journeys, set_ups, strict=True):
            goes_on = bool(found) and not journey.enters
            released = tuple(setting.clearing.released(journey))
            parts = list(self._moments(journey, own, released, found.pop() if goes_on else None))
            found += [replace(p, standing=_within(standing, p)) for p in parts]
        return tuple(found)

    # the day ----------------------------------------------------------------------------------------------------------

    def _journeys(self, lie_right: frozenset[tuple[str, str]]) -> dict[str, tuple[TrainJourney, ...]]:
        found: dict[str, tuple[TrainJourney, ...]] = {}
        for stock_id, trains in self._day.trains.items():
            run: list[TrainJourney] = []
            setting = self.setting(stock_id, lie_right)
            driving = self._driving[stock_id]
            for train in trains:
                ready_s = run[-1].ends_s if run else self.opens_s
                if run and not train.duty.enters:
                    ready_s += self.setup.turn_s
                elif run:
                    ready_s = self.over_s(run[-1])
                run.append(driving.journey(train, setting, ready_s))
            found[stock_id] = tuple(run)
        return found

    def _lie_right(self, journeys: Mapping[str, Sequence[TrainJourney]]) -> frozenset[tuple[str, str]]:
        """The points that the train before left as this one needs them, by train number."""
        commands: list[tuple[float, str, str, Position]] = []
        for stock_id, run in journeys.items():
            setting = self.setting(stock_id)
            for journey in run:
                for span, set_up in setting.set_ups(journey).items():
                    needs = zip(journey.plan.spans[span].points, set_up.throwing, strict=True)
                    commands += [(t.sent_s, journey.number, n.points_id, n.position) for n, t in needs]
        lies = {points.id: points.initial for points in self.setup.line.points.values()}
        right: set[tuple[str, str]] = set()
        for _, number, points_id, position in sorted(commands, key=lambda c: c[:3]):
            if lies[points_id] is position:
                right.add((number, points_id))
            lies[points_id] = position
        return frozenset(right)

    def over_s(self, journey: TrainJourney) -> float:
        """When nothing follows of a journey, s. At a portal its crew signs off, it is heard and answered, and then it
        goes through the portal, whose contact sees it.
        """
        if not journey.leaves:
            return journey.ends_s
        people = self.setup.people
        return journey.ends_s + people.mean_s(Pause.SIGN_OFF) + self.links.ask_s + people.mean_s(Pause.LEAVE)

    # the moments of one journey ---------------------------------------------------------------------------------------

    def _moments(
        self,
        journey: TrainJourney,
        set_ups: Mapping[int, SetUp],
        released: Sequence[ReleaseTimes],
        before: SectionPassage | None,
    ) -> Iterator[SectionPassage]:
        """The sections of a journey; `before`: where it begins, as its stock has it since the train before."""
        spans = journey.mission.spans
        for index, span in enumerate(spans):
            passage = before if index == 0 else self._set(journey, index, set_ups[index])
            if passage is None:
                passage = self._first(journey)
            leaves_s = journey.at_s(span.end_m)
            rear_s = journey.at_s(span.end_m + journey.length_m)
            safe_rear_s, reported_s = released[index]
            freed_s = reported_s + self.links.report_s
            if index + 1 == len(spans) and journey.leaves:  # it signs off where it stands
                stands_s = journey.stays[-1].arrives_s
                leaves_s = rear_s = stands_s
                safe_rear_s = reported_s = stands_s
                freed_s = self.over_s(journey)
            own = replace(
                passage,
                leaves_s=leaves_s,
                rear_s=rear_s,
                safe_rear_s=safe_rear_s,
                reported_s=reported_s,
                freed_s=freed_s,
            )
            yield own
            if index:
                yield from self._overlaps(journey, own, set_ups)

    def _overlaps(
        self, journey: TrainJourney, own: SectionPassage, set_ups: Mapping[int, SetUp]
    ) -> Iterator[SectionPassage]:
        """What is this train's alone by the rule of `wayside.entering`, once it has passed points."""
        leg = next(leg for leg in journey.plan.legs if own.section_id in leg.section_ids)
        route = next(r for r in journey.mission.routes if r.id == leg.route_id)
        if overlap_id(own.section_id) in overlaps_going_out(self.setup.believed_line, route):
            yield replace(own, section_id=overlap_id(own.section_id))
        elif route.entry and own.section_id == route.entry[-1]:
            enters_s = journey.at_s(journey.mission.spans[journey.mission.span_index(leg.entry[0])].start_m)
            leave = self.setting(journey.stock_id).leave(journey, leg, set_ups)
            came = replace(
                own,
                wanted_s=leave.wanted_s,
                sent_s=leave.sent_s,
                heard_s=leave.heard_s,
                held_s=leave.held_s,
                enters_s=enters_s,
            )
            for name in overlaps_coming_in(self.setup.believed_line, route):
                yield replace(came, section_id=name)

    def _set(self, journey: TrainJourney, index: int, set_up: SetUp) -> SectionPassage:
        span = journey.mission.spans[index]
        return SectionPassage(
            span.section_id,
            journey.stock_id,
            journey.number,
            journey.direction,
            set_up.route_id,
            set_up.wanted_s,
            set_up.sent_s,
            set_up.heard_s,
            set_up.held_s,
            journey.at_s(span.start_m),
            *(math.inf,) * 5,
            throwing=set_up.throwing,
        )

    def _first(self, journey: TrainJourney) -> SectionPassage:
        """The section where a stock begins: a portal by which it signs on, or a track on which it stood."""
        span, wanted_s, links = journey.mission.spans[0], journey.begins_s, self.links
        sent_s = heard_s = held_s = wanted_s
        enters_s = -math.inf
        if journey.enters:
            sent_s = wanted_s + links.request_s
            heard_s = sent_s + links.delay_s
            held_s = wanted_s + links.ask_s
            enters_s = held_s + self.setup.people.mean_s(Pause.ENTRY)
        return SectionPassage(
            span.section_id,
            journey.stock_id,
            journey.number,
            journey.direction,
            "",
            wanted_s,
            sent_s,
            heard_s,
            held_s,
            enters_s,
            math.inf,
            math.inf,
            math.inf,
            math.inf,
            math.inf,
        )

    # what it stands for -----------------------------------------------------------------------------------------------

    def _standing(
        self, stock_id: str, journeys: Sequence[TrainJourney], set_ups: Sequence[Mapping[int, SetUp]]
    ) -> Iterator[PassageStand]:
        """All stands of a stock, until it moves; of what goes on at once the last one noted counts."""
        change_s, moves_s = self.setup.turn_s, self._driving[stock_id].start.moves_s
        for at, journey in enumerate(journeys):
            follows = journeys[at + 1] if at + 1 < len(journeys) and not journeys[at + 1].enters else None
            first, *between, last = journey.stays
            stands = [(OccupationPart.DWELL, stay.target, stay.arrives_s, stay.departs_s) for stay in between]
            if at == 0 or journey.enters:
                part = OccupationPart.HELD if journey.enters else OccupationPart.LAYOVER
                stands.insert(0, (part, first.target, first.arrives_s, first.departs_s))
            if not journey.leaves:
                leaves_s = math.inf if follows is None else follows.stays[0].departs_s
                stands.append((OccupationPart.LAYOVER, last.target, last.arrives_s, leaves_s))
            for part, target, from_s, to_s in stands:
                yield PassageStand(part, from_s, to_s)
                yield from self._charging(stock_id, journey, target, from_s, to_s)
                yield PassageStand(OccupationPart.START, to_s, to_s + moves_s)
            if journey.enters:
                yield from _setting_out(set_ups[at], first.departs_s)
            if follows is not None:
                yield from _setting_out(set_ups[at + 1], follows.stays[0].departs_s)
                yield PassageStand(OccupationPart.RELEASE, last.arrives_s, journey.ends_s)
                yield PassageStand(OccupationPart.CHANGE_ENDS, journey.ends_s, journey.ends_s + change_s)

    def _charging(
        self, stock_id: str, journey: TrainJourney, target: int, from_s: float, to_s: float
    ) -> Iterator[PassageStand]:
        """The time at a charger, with raising and lowering the pantograph, where it is worth raising."""
        line = self.setup.line
        charger = line.chargers.get(charger_at(line, journey.mission.targets[target]))
        if self.setup.battery is None or self.setup.trains[stock_id].battery is None or charger is None:
            return
        down_s = to_s - READY_S
        if from_s + charger.connect_s + WORTH_S <= down_s - charger.disconnect_s:
            yield PassageStand(OccupationPart.CHARGING, from_s, down_s)


def _setting_out(set_ups: Mapping[int, SetUp], departs_s: float) -> Iterator[PassageStand]:
    """What a train that has just taken up its number stands for until its way is set: it could not ask sooner."""
    first = set_ups.get(1)
    if first is None:
        return
    throwing = [t for one in set_ups.values() if one.route_id == first.route_id for t in one.throwing]
    yield from setting_out(first.sent_s, first.heard_s, first.held_s, throwing, departs_s)


def _within(standing: Sequence[PassageStand], passage: SectionPassage) -> tuple[PassageStand, ...]:
    return tuple(s for s in standing if s.end_s > passage.wanted_s and s.begin_s < passage.freed_s)
