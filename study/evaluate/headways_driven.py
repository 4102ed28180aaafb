"""Least headways driven: two trains as near to each other as a headway says, and a second nearer.

Nothing is drawn, and the second train asks for its way as late as it can (`study.capacity.two_trains`). It is late
where it leaves or arrives later than when nobody is in its way: at a least headway it is not, with a second less it is.
Trains are driven a few parts in a thousand quicker or slower than predicted, since they keep a speed between two
notches and brake by them. So each headway is driven with what its ways took when nobody was in the way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from host.scratch import scratch
from scenario.scenario import Scenario
from simulation.setup import STEP_S, Setup
from study.capacity.claims import Event, LegRun
from study.capacity.headway import HeadwayCase
from study.capacity.legs import SetLeg, legs_of, places_of
from study.capacity.observed import occupations_run
from study.capacity.occupation import TOUCH_S
from study.capacity.two_trains import (
    NoSuchDayError,
    TwoTrains,
    TwoTrainTimes,
    asks_again_s,
    deciding_leg,
    is_had_on_the_way,
    spared_s,
    thrown_s,
    two_trains,
    ways_to_ask,
)
from study.measures.register_holds import section_holds
from study.record.columns import tenth
from study.runner.run import TEMPORARY, CarrierKind, RunOptions, carrier_factory, run_to_end
from sumo_cfg.build import net_for
from sumo_cfg.truth_map import read_net

DRIVING_COUNTS = True  # off: both trains are held against the way that was predicted for them
ASKS_AS_FREED = True  # off: who has a part of its way asks for the rest up to five seconds after it is free
WAY_COUNTS = (
    True  # off: a second train whose event is its departure may be held up on its way as long as it likes
)
AT_THAT_TIME = (
    True  # off: who chose the next lower cruising speed at another time of the day counts as held up
)
LATE_S: Final = 0.25  # trains stop to a few centimetres, by seed and step: who is later than that was held up
OTHER_PACE_S: Final = 1.0  # by which a train may be later that has chosen the next lower cruising speed
LESS_S: Final = 1.0
FAR_S: Final = 14_400  # trains so far apart do not meet
OFF_S: Final = 64  # so far from a headway it is looked for in what trains need


@dataclass(frozen=True, slots=True)
class DrivenHeadway:
    """A headway as it was driven, s.

    `driving_s`: by so much longer than predicted the two take, alone, for what the headway runs over. `spared_s`: so
    much less, at most, they may be apart as the points by which the second leaves lie right. `kept_s`: by how much the
    second is late at most with the headway and `driving_s`, less `spared_s` if that is all spared; `nearer_s`: with a
    second less; infinite where it does not come. `needs_s`: the least time between the two events, to a second, with
    which it is not late; `why` says why the two cannot be driven.
    """

    case: HeadwayCase
    driving_s: float = 0.0
    spared_s: float = 0.0
    kept_s: float = math.nan
    nearer_s: float = math.nan
    needs_s: float = math.nan
    why: str = ""

    @property
    def agrees(self) -> bool:
        """Whether a run needs what the headway says."""
        return self.kept_s <= LATE_S < self.nearer_s

    @property
    def longer_s(self) -> float:
        """By how much the headway is longer than a run needs; what is within a second of 0 below is not known."""
        return self.case.headway.least_s - self.needs_s

    @property
    def unexplained_s(self) -> float:
        """What of that is neither driving nor points that lie right; they spare less where something else decides."""
        longer_s = self.longer_s + self.driving_s
        return longer_s - min(max(longer_s, 0.0), self.spared_s)

    @property
    def text(self) -> str:
        """In words."""
        if self.why:
            return f"not driven: {self.why}"
        right = f", up to {self.spared_s:.1f} s less as points lie right" if self.spared_s else ""
        found = f"least {self.case.headway.least_s:.1f} s, as driven {self.driving_s:+.1f} s{right}"
        late = f"{self.kept_s:.1f} s late at it, {self.nearer_s:.1f} s with a second less"
        return f"{found}; a run needs {self._needs_text}; {late}"

    @property
    def _needs_text(self) -> str:
        if math.isfinite(self.needs_s):
            return f"{self.needs_s:.1f} s"
        more = "more" if self.needs_s > 0.0 else "less"
        return f"over {OFF_S} s {more}, and was not looked for further"

    def as_dict(self) -> dict[str, Any]:
        """For JSON and CSV: times to 0.1 s."""
        return {
            "driven_driving_s": tenth(self.driving_s),
            "driven_spared_s": tenth(self.spared_s),
            "driven_kept_s": tenth(self.kept_s),
            "driven_nearer_s": tenth(self.nearer_s),
            "driven_needs_s": tenth(self.needs_s),
            "driven_why": self.why,
        }


class HeadwayDrives:
    """Runs of two trains on the line of a scenario in which nothing is drawn."""

    def __init__(self, scenario: Scenario, folder: Path) -> None:
        line, net = scenario.setup.line, net_for(scenario.setup.line, folder)
        self.setup: Final[Setup] = scenario.setup
        self._scenario = scenario
        self._folder = folder
        self._make = carrier_factory(CarrierKind.PLAIN, line, net)
        self._map = read_net(net)
        self._is_place = places_of(line)

    def drive_headway(self, case: HeadwayCase, *, searched: bool = True) -> DrivenHeadway:
        """A headway driven; what a run needs instead is looked for where it differs, if that is asked for."""
        try:
            drive = _Drive(self, two_trains(self.setup, case.headway))
            return drive.driven(case, searched=searched)
        except NoSuchDayError as error:
            return DrivenHeadway(case, why=str(error))

    def legs(self, setup: Setup) -> tuple[SetLeg, ...]:
        """The legs of a day, as run."""
        with scratch(TEMPORARY, self._folder) as folder:
            course = RunOptions(self._make, self._map, folder)
            setup, result = run_to_end(replace(self._scenario, setup=setup), course)
        return legs_of(
            occupations_run(result, setup.line, section_holds(result, setup.line, setup.lengths_m)),
            self._is_place,
        )


class _Drive:
    """The drives of one headway."""

    def __init__(self, drives: HeadwayDrives, two: TwoTrains) -> None:
        self._drives, self._two = drives, two
        try:  # far apart, so that points lie as the first one leaves them
            self._unhindered(drives.legs(two.day(two.first, two.second.later(FAR_S))), FAR_S)
        except NoSuchDayError:  # where the one ends the other begins
            both = drives.legs(two.day(two.first)), drives.legs(two.day(two.second))
            self._unhindered([*both[0], *both[1]], 0)
        self._spared_s = 0.0
        self._late_s: dict[int, float] = {}

    def _unhindered(self, legs: Sequence[SetLeg], by_s: int) -> None:
        """How the two run when neither is in the other's way, the second so much later."""
        headway = self._two.headway
        self._way = [_as(legs, leg) for leg in reversed(headway.claims.behind)]
        one, other = _as(legs, headway.first.leg), _as(legs, headway.second.leg)
        self._apart_s = _at_s(headway.second, other) - _at_s(headway.first, one) - by_s
        self._later_s = by_s
        on_the_way = is_had_on_the_way(headway)
        self._waits_on = self._way[-1 - deciding_leg(headway)] if on_the_way else None
        frees = [run for run in headway.claims.runs if run.frees == headway.section_id]
        self._freed_s = max((_until_s(run, legs) for run in frees), default=math.inf)
        longer_s = (_longer_s(run, legs) for run in headway.claims.runs)
        self._driving_s = math.fsum(s for s in longer_s if math.isfinite(s)) if DRIVING_COUNTS else 0.0

    def driven(self, case: HeadwayCase, *, searched: bool) -> DrivenHeadway:
        found = self._at_least(case, 0.0)
        if found.kept_s <= LATE_S and not found.agrees:
            spared_s = self._spared()
            less = self._at_least(case, spared_s) if spared_s else found
            found = less if less.agrees else replace(self._at_least(case, 0.0), spared_s=spared_s)
        if not searched:
            return found
        kept, nearer = self._times(self._spared_s)
        needs_s = self._needs(kept if found.nearer_s > LATE_S else nearer)
        return replace(found, needs_s=self._apart_s + needs_s)

    def _at_least(self, case: HeadwayCase, spared_s: float) -> DrivenHeadway:
        """The headway driven, the second asking so much later."""
        self._spared_s, self._late_s = spared_s, {}
        kept, nearer = (self.late_s(by_s) for by_s in self._times(spared_s))
        needs_s = case.headway.least_s + self._driving_s - spared_s
        return DrivenHeadway(case, self._driving_s, spared_s, kept, nearer, needs_s)

    def _times(self, spared_s: float) -> tuple[int, int]:
        """The whole seconds, later than alone, by which a headway is kept, and by which a second is missing."""
        least_s = self._two.headway.least_s + self._driving_s - spared_s - self._apart_s
        return math.ceil(least_s + STEP_S - TOUCH_S), math.floor(least_s - LESS_S + TOUCH_S)

    def _spared(self) -> float:
        """How long the second need not wait for the points by which it leaves: behind the first they lie right."""
        leg = self._two.headway.claims.behind[deciding_leg(self._two.headway)]
        headway = self._two.headway
        less_s = thrown_s(headway, leg) - thrown_s(headway, _as(self._both(self._times(0.0)[0]), leg))
        return spared_s(self._two, less_s) if less_s > STEP_S else 0.0

    def _both(self, by_s: int, times: TwoTrainTimes = TwoTrainTimes()) -> tuple[SetLeg, ...]:  # noqa: B008 - it is frozen
        two = two_trains(self._drives.setup, self._two.headway, times)
        return self._drives.legs(two.day(two.first, two.second.later(by_s)))

    def late_s(self, by_s: int) -> float:
        """By how much the second train is late at most, so much later than it was alone, up to its event; by the least
        of the ways in which the two can ask.
        """
        if by_s not in self._late_s:
            late_s = math.inf
            sooner_s = self._asks_sooner_s(by_s - self._later_s)
            for times in ways_to_ask(self._two.headway, self._spared_s, sooner_s):
                late_s = min(late_s, self._late_by_s(by_s, times))
                if late_s <= LATE_S:
                    break
            self._late_s[by_s] = late_s
        return self._late_s[by_s]

    def _late_by_s(self, by_s: int, times: TwoTrainTimes) -> float:
        """The same, by one way to ask. A cruising speed is chosen by the time left, and may be the next one at another
        time of the day: who is late by no more than that can make is held against itself at that time.
        """
        both = self._both(by_s, times)
        late_s = self._held_up_s(both, self._way, by_s - self._later_s)
        if not (AT_THAT_TIME and LATE_S < late_s <= OTHER_PACE_S):
            return late_s
        two = two_trains(self._drives.setup, self._two.headway, times)
        try:
            alone = self._drives.legs(two.day(two.first.later(-FAR_S), two.second.later(by_s)))
            return self._held_up_s(both, [_as(alone, leg) for leg in self._way], 0.0)
        except NoSuchDayError:
            return late_s

    def _asks_sooner_s(self, later_s: float) -> float:
        """How much sooner the second must ask for its way to ask for the rest of it as the first has freed that, s."""
        if self._waits_on is None or not ASKS_AS_FREED:
            return 0.0
        asks_s = self._waits_on.occupations[0].begin_s + later_s
        return (asks_s - self._freed_s) % asks_again_s(self._two.setup)

    def _held_up_s(self, both: Sequence[SetLeg], way: Sequence[SetLeg], later_s: float) -> float:
        """By how much its legs among both are later at most than those of a way so much later, s.

        Who is let onto a part of a way departs in time all the same, and is held up where it waits for the rest.
        """
        late_s = -math.inf
        for leg in way:
            try:
                own = _as(both, leg)
            except NoSuchDayError:
                return math.inf
            late_s = max(late_s, own.departs_s - leg.departs_s - later_s)
            if leg is not way[-1] or self._two.headway.second.arrival:
                late_s = max(late_s, own.arrives_s - leg.arrives_s - later_s)
            if WAY_COUNTS and self._waits_on is not None and _is_same(leg, self._waits_on):
                late_s = max(late_s, _enters_s(own, self._two) - _enters_s(leg, self._two) - later_s)
        return late_s

    def _needs(self, near: int) -> float:
        """The least whole time by which the second is not late, OFF_S from one that is near at most."""
        late = self.late_s(near) > LATE_S
        step = 1
        while step <= OFF_S and (self.late_s(near + step if late else near - step) > LATE_S) == late:
            step *= 2
        if step > OFF_S:
            return math.inf if late else -math.inf
        low, high = (near + step // 2, near + step) if late else (near - step, near - step // 2)
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self.late_s(middle) > LATE_S else (low, middle)
        return high


def _as(legs: Sequence[SetLeg], leg: SetLeg) -> SetLeg:
    """The same leg as it was run."""
    for one in legs:
        if _is_same(one, leg):
            return one
    raise NoSuchDayError(f"{leg.number} does not come from {_ends(leg)[0]} to {_ends(leg)[1]}")


def _is_same(one: SetLeg, other: SetLeg) -> bool:
    return one.number == other.number and _ends(one) == _ends(other)


def _enters_s(leg: SetLeg, two: TwoTrains) -> float:
    """When the front comes into the section that decides, s."""
    return next(o.enters_s for o in leg.occupations if o.section_id == two.headway.section_id)


def _longer_s(run: LegRun, legs: Sequence[SetLeg]) -> float:
    """By how much longer than predicted a stretch takes as it was run, s; infinite where it has no end."""
    leg = _as(legs, run.leg)
    from_s = next((o.enters_s for o in leg.occupations if o.section_id == run.enters), leg.departs_s)
    longer_s = _until_s(run, legs) - from_s - run.lasts_s
    return -longer_s if run.back else longer_s


def _until_s(run: LegRun, legs: Sequence[SetLeg]) -> float:
    """When a stretch as it was run is over, s; infinite where it has no end."""
    leg = _as(legs, run.leg)
    if run.frees:
        return next((o.end_s for o in leg.held if o.section_id == run.frees), math.inf)
    return leg.arrives_s if run.follows is None else _as(legs, run.follows).departs_s


def _ends(leg: SetLeg) -> tuple[str, str]:
    start, end = leg.start, leg.end
    return "" if start is None else start.section_id, "" if end is None else end.section_id


def _at_s(event: Event, leg: SetLeg) -> float:
    return leg.arrives_s if event.arrival else leg.departs_s
