"""A headway as a day of two trains: those legs of the plan that it is about, the second as near to the first as wanted.

The first begins where it starts its leg, or has come there long before, and goes on as far as counts; the second has
stood where its way in begins since the morning. Each leg keeps its times of the plan, and is moved as a whole, so that
all stands between are the shortest (`study.capacity.claims`).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from network.clock import first_given
from network.model import Line, SectionKind
from network.timetable import AtPortal, BecomesTrain, Call, Diagram, FromTrain, Stabled, TimetableTrain
from onboard.authority.tables import REFUSED_REPEAT_S
from radio.air import AirParameters, DelayShape
from simulation.faults.script import Script
from simulation.late.settings import Late
from simulation.people import Pause
from simulation.settings import Dispatch
from simulation.setup import STEP_S, Setup
from study.capacity.headway import Headway
from study.capacity.legs import SetLeg, stand_of
from study.capacity.links import Links
from study.capacity.occupation import TOUCH_S, OccupationPart
from study.feasibility.planned import planned_day

EARLY_AIM_IS_NO_LEAD = True  # off: who aims early at an arrival is early at its portal, and runs slowly
FIRST_GOES_ON = True  # off: a first train may stay where the second is to come
NOON_S: Final = 43_200
WAITS_S: Final = 1_800  # a first train that had to come from elsewhere is there so long before its leg
COMES_S: Final = 300  # and a second one
WAITS_MORE_S: Final = 4  # beyond that a refused unit asks again by itself


class NoSuchDayError(ValueError):
    """A headway whose two trains cannot be cut out of the plan."""


@dataclass(frozen=True, slots=True)
class SingleLegTrains:
    """Legs of one set as trains of their own."""

    stock_id: str
    trains: tuple[TimetableTrain, ...]

    def later(self, by_s: int) -> SingleLegTrains:
        """The same so much later."""
        moved = (replace(t, calls=tuple(_moved(call, by_s, by_s) for call in t.calls)) for t in self.trains)
        return SingleLegTrains(self.stock_id, tuple(moved))


@dataclass(frozen=True, slots=True)
class TwoTrains:
    """A headway's two trains, each from noon on as if it were alone, and the setup in which they run."""

    setup: Setup
    headway: Headway
    first: SingleLegTrains
    second: SingleLegTrains

    def day(self, *alone: SingleLegTrains) -> Setup:
        """A day with nothing but some sets."""
        return day_of(self.setup, alone)


def undisturbed_setup(setup: Setup) -> Setup:
    """A setup in which nothing is drawn: the air, people and passengers as they are on average, wheels as new.

    Units know their wheels from the first metre on as well as else after some stations.
    """
    delay_s = max(STEP_S, round(setup.radio_on_average.delay_s / STEP_S) * STEP_S)
    unit = setup.unit
    growth = min(2.0 * unit.wheel_varies_share, unit.wheel_error_share)
    return replace(
        setup,
        unit=unit.model_copy(update={"wheel_error_share": growth, "wheel_scale_limit": 0.0}),
        sensors=setup.sensors.model_copy(update={"wheel_factor_sigma": 0.0}),
        air=AirParameters(delay_min_s=delay_s, delay_mean_s=delay_s, delay_shape=DelayShape.CONSTANT),
        second_air=None,
        people=setup.people.model_copy(update={"sigma": 0.0}),
        load=setup.load.model_copy(update={"load_share_spread": 0.0}),
        dispatch=Dispatch(certificate=setup.grants_parts),
        late=Late(),
        script=Script(),
    )


@dataclass(frozen=True, slots=True)
class TwoTrainTimes:
    """When two trains ask and set out where a headway leaves it open.

    `spared_s`: so much later the second can ask, as its points lie right. `asks`: for which of its legs it asks as late
    as it can, None: that which decides. `waits_more_s`: so much longer the first stands wherever it waits.
    `comes_sooner_s`: so much sooner the second comes to where the leg that decides begins, and stands longer there: one
    that turns asks first when it has changed ends. `asks_sooner_s`: so much sooner each unit asks for its ways, so that
    a second that has a part of one asks for the rest just as that is free.
    """

    spared_s: float = 0.0
    asks: int | None = None
    waits_more_s: int = 0
    comes_sooner_s: int = 0
    asks_sooner_s: float = 0.0


def two_trains(setup: Setup, headway: Headway, times: TwoTrainTimes = TwoTrainTimes()) -> TwoTrains:
    """The two trains of a headway of an undisturbed setup. Raises NoSuchDayError."""
    first, second = headway.first, headway.second
    ends, begins = len(headway.claims.ahead) - 1, len(headway.claims.behind) - 1
    claims = headway.claims
    longer_s = [wait_s + times.waits_more_s if wait_s > TOUCH_S else 0.0 for wait_s in claims.ahead_waits_s]
    ahead = _LegsOfSet(setup, claims.ahead, first.before, first.after[ends:], WAITS_S, (), longer_s)
    waits_s = list(claims.behind_waits_s)
    waits_s[deciding_leg(headway)] += times.comes_sooner_s
    way_in, waits_s = claims.behind[::-1], waits_s[::-1]
    before = second.before[begins:]
    behind = _LegsOfSet(setup, way_in, before, second.after, COMES_S, ahead.places, waits_s)
    if FIRST_GOES_ON and setup.grants_parts and ahead.ends_in in behind.comes_to:
        after = first.after[ends:]
        ahead = _LegsOfSet(setup, claims.ahead, first.before, after, WAITS_S, (), longer_s, behind.comes_to)
    alone = ahead.alone(), behind.alone().later(-times.comes_sooner_s)
    return TwoTrains(_asks_late(setup, headway, alone[1], times), headway, *alone)


def ways_to_ask(headway: Headway, spared_s: float, asks_sooner_s: float) -> Iterator[TwoTrainTimes]:
    """How two trains may ask, the likeliest first.

    A unit that is refused asks again every few seconds, and asks as early before every leg: a second that needs two
    ways so tightly, or a first that waits for the second, comes later than it must by how it asks alone.
    """
    yield TwoTrainTimes(spared_s)
    if asks_sooner_s > TOUCH_S:
        yield TwoTrainTimes(spared_s, asks_sooner_s=asks_sooner_s)
    if any(wait_s > TOUCH_S for wait_s in headway.claims.ahead_waits_s):
        yield from (TwoTrainTimes(spared_s, waits_more_s=more_s) for more_s in range(1, WAITS_MORE_S + 1))
    wants_s = [round(_wants_s(leg), 3) for leg in headway.claims.behind]
    if 0 <= deciding_leg(headway) < len(headway.claims.behind) - 1:
        yield from (
            TwoTrainTimes(spared_s, comes_sooner_s=s) for s in range(1, math.ceil(REFUSED_REPEAT_S) + 1)
        )
    for asks in {s: at for at, s in enumerate(wants_s)}.values():
        if wants_s[asks] > wants_s[deciding_leg(headway)]:
            yield TwoTrainTimes(spared_s, asks)


def deciding_leg(headway: Headway) -> int:
    """Which leg of those of the second needs what decides; -1: it is the portal at which it signs on."""
    ways = (i for i, leg in enumerate(headway.claims.behind) if _has(leg, headway.section_id))
    return next(ways, -1)


def _asks_late(setup: Setup, headway: Headway, second: SingleLegTrains, times: TwoTrainTimes) -> Setup:
    """A setup in which the second train of a headway asks as late as it can, and units aim at arrivals as they stand.

    Who asks sooner is refused, and asks again at fixed intervals: every unit asks so many of them sooner that the way
    of each can be set meanwhile. A train comes to its portal in time to sign on as late as it can.
    """
    links, people = Links.of(setup.radio_on_average), setup.people
    wants_s = [_wants_s(leg) for leg in headway.claims.behind]
    wants_s[deciding_leg(headway)] -= times.spared_s
    own_s = wants_s[deciding_leg(headway) if times.asks is None else times.asks]
    longest_s = links.ask_s + links.set_s(
        max((p.throw_time_s for p in setup.line.points.values()), default=0.0)
    )
    again_s = asks_again_s(setup)
    refused = math.ceil(max(longest_s - own_s, 0.0) / again_s - TOUCH_S)
    comes = planned_day(day_of(setup, [second])).trains[second.stock_id][0]
    first_call = second.trains[0].calls[0]
    portal_lead_s = first_call.first_s - comes.stands[0].departs_s
    if first_call.arrival_s is not None and EARLY_AIM_IS_NO_LEAD:  # see _aims_at_s
        portal_lead_s -= setup.unit.time_margin_s
    portal_lead_s += people.mean_s(Pause.SIGN_ON) + links.ask_s + max(wants_s[-1], people.mean_s(Pause.ENTRY))
    return replace(
        setup,
        unit=setup.unit.model_copy(
            update={
                "request_lead_s": own_s + refused * again_s + times.asks_sooner_s,
                "time_margin_s": 0.0,
            }
        ),
        operation=setup.operation.model_copy(update={"portal_lead_s": portal_lead_s}),
    )


def asks_again_s(setup: Setup) -> float:
    """After how long a unit that is refused asks again, s; and who has a part of a way, for the rest."""
    return REFUSED_REPEAT_S + 2.0 * Links.of(setup.radio_on_average).delay_s


def is_had_on_the_way(headway: Headway) -> bool:
    """Whether the second has left by a part of its way when it needs what decides."""
    leg = headway.claims.behind[deciding_leg(headway)]
    return any(o.section_id == headway.section_id and o.begin_s > leg.departs_s for o in leg.occupations)


def spared_s(two: TwoTrains, less_s: float) -> float:
    """How much later the second can ask for what decides where its points take so much less, s.

    Who comes in by a portal takes its time for that, however its points lie.
    """
    leg = two.headway.claims.behind[deciding_leg(two.headway)]
    if is_had_on_the_way(two.headway) or not _enters(two.setup, leg):
        return less_s
    return min(less_s, max(_wants_s(leg) - two.setup.people.mean_s(Pause.ENTRY), 0.0))


def thrown_s(headway: Headway, leg: SetLeg) -> float:
    """How long points are thrown for what decides, s: those that take longest, of the second's leg as computed or run.

    Before it departs; on its way, where it then has the part of its way that decides.
    """
    computed = headway.claims.behind[deciding_leg(headway)]
    if not is_had_on_the_way(headway):
        before = (s for one in leg.occupations for s in one.slices if s.end_s <= leg.departs_s)
        throws = (s for s in before if s.part is OccupationPart.THROW)
        return 0.0 if leg.start is None else max((s.length_s for s in throws), default=0.0)
    begins_s = next(o.begin_s for o in computed.occupations if o.section_id == headway.section_id)
    had = {o.section_id for o in computed.occupations if abs(o.begin_s - begins_s) <= TOUCH_S}
    own = (s for o in leg.occupations if o.section_id in had for s in o.slices)
    return max((s.length_s for s in own if s.part is OccupationPart.THROW), default=0.0)


def _enters(setup: Setup, leg: SetLeg) -> bool:
    begins = setup.timetable.trains[leg.number].begins
    return (
        isinstance(begins, AtPortal) and leg.start is not None and leg.start.section_id == begins.section_id
    )


def _has(leg: SetLeg, section_id: str) -> bool:
    return any(one.section_id == section_id for one in leg.occupations)


def _wants_s(leg: SetLeg) -> float:
    """How long before its word to leave a leg's way is wanted, s."""
    return leg.departs_s - _starts_s(leg) - leg.occupations[0].begin_s


def _starts_s(leg: SetLeg) -> float:
    """From the word to leave until it moves, s."""
    return 0.0 if leg.start is None else leg.start.of_part(OccupationPart.START)


def day_of(setup: Setup, alone: Sequence[SingleLegTrains]) -> Setup:
    """A day with nothing but some sets."""
    trains = {train.number: train for one in alone for train in one.trains}
    sets = tuple(Diagram(one.stock_id, tuple(train.number for train in one.trains)) for one in alone)
    kinds = {one.stock_id: setup.trains[one.stock_id] for one in alone}
    return replace(setup, timetable=replace(setup.timetable, trains=trains, diagrams=sets), trains=kinds)


class _LegsOfSet:
    """Legs of a set, and those before (the nearest first) and after them, by which they are made whole trains.

    It is `waits_s` at the first of the legs, if it had to come there; it begins in none of the `taken` places, and ends
    in none of those that are to be `left`. Before each leg it stands for so much longer than it must (`stands_s`).
    """

    def __init__(
        self,
        setup: Setup,
        legs: Sequence[SetLeg],
        before: Sequence[SetLeg],
        after: Sequence[SetLeg],
        waits_s: int,
        taken: Collection[str] = (),
        stands_s: Sequence[float] = (),
        left: Collection[str] = (),
    ) -> None:
        self._setup = setup
        self._stands_s = {id(leg): s for leg, s in zip(legs, stands_s, strict=bool(stands_s))}
        self._waits_s = waits_s
        self._taken, self._left = taken, left
        self._counts = {id(leg) for leg in legs}
        self._legs = list(legs)
        back, on = list(before), list(after)
        while back and not (
            self._begins() and (_enters(self._setup, self._legs[0]) or self._runs(self._legs[0]))
        ):
            self._legs.insert(0, back.pop(0))
        while on and not (self._ends() and (self._leaves(self._legs[-1]) or self._runs(self._legs[-1]))):
            self._legs.append(on.pop(0))
        whole = self._runs(self._legs[0]) and self._runs(self._legs[-1])
        if not (whole and self._begins() and self._ends()):
            raise NoSuchDayError(f"{legs[0].number}: no stop at which it could begin, or end")

    @property
    def places(self) -> frozenset[str]:
        """Where it is until it sets out on the legs that count; a portal is anybody's again."""
        counts = next(at for at, leg in enumerate(self._legs) if id(leg) in self._counts)
        found = [leg.start for leg in self._legs[: counts + 1] if leg.start is not None]
        kinds = self._setup.line.sections
        return frozenset(o.section_id for o in found if kinds[o.section_id].kind is not SectionKind.PORTAL)

    @property
    def comes_to(self) -> frozenset[str]:
        """Where its legs end."""
        return frozenset(leg.end.section_id for leg in self._legs if leg.end is not None)

    @property
    def ends_in(self) -> str:
        """Where its last leg ends."""
        end = self._legs[-1].end
        return "" if end is None else end.section_id

    def alone(self) -> SingleLegTrains:
        """As trains of their own."""
        moves_s = self._moves_s()
        numbers = list(dict.fromkeys(leg.number for leg in self._legs))
        trains = [self._train(number, moves_s) for number in numbers]
        for at in range(1, len(trains)):
            trains[at - 1] = replace(trains[at - 1], ends=BecomesTrain(numbers[at]))
            trains[at] = replace(trains[at], begins=FromTrain(numbers[at - 1]))
        return SingleLegTrains(self._legs[0].stock_id, tuple(trains))

    def _begins(self) -> bool:
        leg = self._legs[0]
        if leg.start is None or leg.start.section_id in self._taken:
            return False
        return _enters(self._setup, leg) or self._stops(leg, leg.start.section_id)

    def _ends(self) -> bool:
        leg = self._legs[-1]
        if leg.end is None or (leg.end.section_id in self._left and not self._leaves(leg)):
            return False
        return self._leaves(leg) or self._stops(leg, leg.end.section_id)

    def _leaves(self, leg: SetLeg) -> bool:
        ends = self._setup.timetable.trains[leg.number].ends
        return isinstance(ends, AtPortal) and leg.end is not None and leg.end.section_id == ends.section_id

    def _stops(self, leg: SetLeg, section_id: str) -> bool:
        train = self._setup.timetable.trains[leg.number]
        at = call_at(self._setup.line, train, section_id)
        return at is not None and train.calls[at].stops

    def _runs(self, leg: SetLeg) -> bool:
        """Whether what there is of the train of a leg has two calls."""
        first, last = self._calls(leg.number)
        return last > first

    def _calls(self, number: str) -> tuple[int, int]:
        """The first and the last call that there are of a train."""
        train, line = self._setup.timetable.trains[number], self._setup.line
        own = [leg for leg in self._legs if leg.number == number]
        start, end = own[0].start, own[-1].end
        first = 0 if start is None or _enters(self._setup, own[0]) else call_at(line, train, start.section_id)
        last = len(train.calls) - 1
        if end is not None and not self._leaves(own[-1]):
            found = call_at(line, train, end.section_id)
            last = last if found is None else found
        return first or 0, last

    def _moves_s(self) -> list[int]:
        """By how much each leg is moved, s: each departs as soon as it can after the one before."""
        dwell_min_s = self._setup.unit.dwell_min_s
        found = [math.floor(NOON_S - self._legs[0].departs_s)]
        for before, leg in zip(self._legs, self._legs[1:], strict=False):
            if leg.start is None or stand_of(leg.start).passes:
                found.append(found[-1])
                continue
            can_s = before.arrives_s + found[-1] + stand_of(leg.start, dwell_min_s).least_s
            if id(leg) in self._counts and id(before) not in self._counts:
                can_s += self._waits_s
            can_s += self._stands_s.get(id(leg), 0.0)
            found.append(math.floor(can_s - leg.departs_s))
        return found

    def _train(self, number: str, moves_s: Sequence[int]) -> TimetableTrain:
        train, line = self._setup.timetable.trains[number], self._setup.line
        own = [(leg, by_s) for leg, by_s in zip(self._legs, moves_s, strict=True) if leg.number == number]
        first, last = self._calls(number)
        leaves = {call_at(line, train, leg.start.section_id): (leg, by_s) for leg, by_s in own if leg.start}
        calls: list[Call] = []
        comes_s = goes_s = own[0][1]
        for index in range(first, last + 1):
            call = train.calls[index]
            if index in leaves:
                leg, goes_s = leaves[index]
                if call.departure_s is None:  # out to a portal as soon as it can
                    call = replace(call, departure_s=math.floor(leg.departs_s - _starts_s(leg)))
            if call.arrival_s is not None:
                call = replace(call, arrival_s=self._aims_at_s(call))
            calls.append(_moved(call, comes_s, goes_s))
            comes_s = goes_s
        end_leg, end_s = own[-1]
        calls[0] = calls[0] if _enters(self._setup, own[0][0]) else replace(calls[0], arrival_s=None)
        if not self._leaves(end_leg):
            arrives_s = first_given(calls[-1].arrival_s, math.floor(end_leg.arrives_s) + end_s)
            calls[-1] = replace(calls[-1], arrival_s=arrives_s, departure_s=None)
        begins = train.begins if _enters(self._setup, own[0][0]) else Stabled()
        ends = train.ends if self._leaves(end_leg) else Stabled()
        return replace(train, calls=tuple(calls), begins=begins, ends=ends)

    def _aims_at_s(self, call: Call) -> int:
        """When its unit aims to be at a call with an arrival, s; that of a shorter stand must not have it hurry."""
        unit = self._setup.unit
        latest_s = call.last_s if call.departure_s is None else call.departure_s - unit.dwell_min_s
        return math.floor(min(call.first_s, latest_s) - unit.time_margin_s)


def call_at(line: Line, train: TimetableTrain, section_id: str) -> int | None:
    """Which call of a train is at the station of a track; None where the section is none, or it does not call there."""
    at = (s.id for s in line.stations.values() if any(t.section_id == section_id for t in s.tracks))
    station_id = next(at, None)
    return next((i for i, call in enumerate(train.calls) if call.station_id == station_id), None)


def _moved(call: Call, comes_s: int, goes_s: int) -> Call:
    arrival_s, departure_s = call.arrival_s, call.departure_s
    return replace(
        call,
        arrival_s=None if arrival_s is None else arrival_s + comes_s,
        departure_s=None if departure_s is None else departure_s + goes_s,
    )
