"""Why every stock stood, waited or ran slower, at every moment of a run (待ちの理由).

Where it truly stood and where it ran is the energy book's (`simulation.result.EnergyRecord`), which is cut by the
truth. Why, is made again from what the unit, the manager, the terminals and the world wrote in the journal. Of several
reasons the one counts that ends last: before its departure time a train waits for that, whatever its route does; but
what is out of order comes first. Nothing here asks a unit: what units show their drivers (`waits_for`) is compared with
it in the tests.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from onboard.duty.stop_limit import NOT_PROVEN
from onboard.vehicle import DOORS_OPEN
from simulation.events import MANAGER, JournalEntry
from simulation.result import EnergyPhase, RunResult
from simulation.setup import STEPS_PER_S, Setup
from simulation.world.roster import Duty, drawn_up
from study.measures.register_holds import SectionHold
from study.measures.stretches import DayStretch, stretches
from study.measures.wait_history import RegisterHistory
from study.measures.wait_view import DutyStage, StockView, WaitingRequest, by_unit
from study.measures.where import Whereabouts
from study.record.wait import AwaitedRequest, Cause, Wait

AT_ITS_STOP: Final = (EnergyPhase.AT_STOP, EnergyPhase.LAYOVER)
SLOWED_SHARE: Final = 0.8  # of the braking to a stop: a train that must brake so hard and does is held back
BRAKES_MPS2: Final = -0.05  # less than this is to hold its speed
ASKS_AGAIN: Final = "asks again"
WRONG_CLOCK: Final = "clock"
NO_PASSENGERS: Final = "operational"
SAMPLES_S: Final = 2.0  # between two samples of the trace passes a second
CABLE_CUT: Final = "cable cut"
NOT_NOW: Final[Mapping[str, Cause]] = {
    "no way on": Cause.NO_WAY_ON,
    "not its turn": Cause.NOT_ITS_TURN,
    "overlap": Cause.OVERLAP,
}
HELD_REASON: Final = "held"  # how a refusal begins that names another holder


def waits_of(result: RunResult, setup: Setup, holds: Iterable[SectionHold]) -> tuple[Wait, ...]:
    """All waits of a run, by stock and time; those of one stock cover the run without gap or overlap."""
    drawn = drawn_up(setup, setup.line)
    entries: dict[str, list[JournalEntry]] = defaultdict(list)
    history = RegisterHistory(by_unit(result.journal.entries, entries), holds)
    where = Whereabouts(result)
    found: list[Wait] = []

    def fresh(unit: str) -> StockView:
        return StockView(unit, drawn.get(unit, ()), setup.unit.dwell_min_s, setup.line, setup.lengths_m[unit])

    as_run = {unit: fresh(unit).duties_after(entries[unit]) for unit in drawn}
    for unit in result.stock_ids:
        view = fresh(unit)
        days = stretches(result, unit)
        finder = _Finder(setup, view, history, where, as_run)
        found += finder.day(days, entries[unit])
    return tuple(found)


class _Finder:
    """Finds the waits of one stock."""

    def __init__(
        self,
        setup: Setup,
        view: StockView,
        history: RegisterHistory,
        where: Whereabouts,
        drawn: Mapping[str, Sequence[Duty]],
    ) -> None:
        self._setup = setup
        self._view = view
        self._history = history
        self._where = where
        self._drawn = drawn
        self._stretch = DayStretch("", "", None, "", "", 0.0, 0.0)
        self._held_back_by: tuple[str, float] | None = None  # the stop limit that slows the train down

    def day(self, days: Sequence[DayStretch], entries: Sequence[JournalEntry]) -> list[Wait]:
        """The waits of the stock's day."""
        found: list[Wait] = []
        taken = 0
        for stretch in days:
            self._stretch = stretch
            self._held_back_by = None
            if stretch.phase is EnergyPhase.RUNNING:
                self._view.departed = True
            times_s = {e.t_s for e in entries if stretch.from_s < e.t_s < stretch.to_s}
            for from_s, to_s in pairwise([stretch.from_s, *sorted(times_s), stretch.to_s]):
                while taken < len(entries) and entries[taken].t_s <= from_s:
                    self._view.take(entries[taken])
                    taken += 1
                _join(found, self._between(from_s, to_s))
        return found

    def _between(self, from_s: float, to_s: float) -> Iterator[Wait]:
        """Waits between two lines of the unit's journal: only time and what others do can change them."""
        if self._stretch.phase is EnergyPhase.RUNNING:
            yield from self._runs(from_s, to_s)
            return
        at_s = from_s
        while at_s < to_s:
            wait, until_s = self._wait(at_s)
            next_s = min(to_s, until_s) if until_s > at_s else to_s
            yield replace(wait, from_s=at_s, to_s=next_s)
            at_s = next_s

    def _make(self, cause: Cause) -> Wait:
        """A wait of this stock where it is now, but for its times and for what it waits for."""
        stretch, view = self._stretch, self._view
        at = None if stretch.phase is None else self._here(stretch.from_s)
        at_m = None if at is None else at[1]
        place = stretch.from_id if stretch.phase in (*AT_ITS_STOP, EnergyPhase.STABLED) else ""
        following = view.next_duty
        train = stretch.train or view.train or ("" if following is None else following.train.number)
        return Wait(view.unit, train, 0.0, 0.0, cause, place, at_m)

    def _here(self, t_s: float) -> tuple[str, float] | None:
        """Piece and kilometrage (m) of its front; of stock that never moves, the mark where its train begins."""
        at, duty = self._where.piece(self._view.unit, t_s), self._view.duty
        if at is None and duty is not None:
            return duty.mission.path.locate(duty.mission.targets[0].mark_m)
        return at

    def _wait(self, t_s: float) -> tuple[Wait, float]:
        """What the stock waits for at a moment, and until when that holds if the unit says nothing, s."""
        phase = self._stretch.phase
        if phase is None:
            return self._off_line(t_s)
        if phase is EnergyPhase.STABLED:
            return self._make(Cause.STABLED), math.inf
        return self._boarding(t_s) or self._out_of_order() or self._by_duty(t_s)

    # off the line ---------------------------------------------------------------------------------------------

    def _off_line(self, t_s: float) -> tuple[Wait, float]:
        view = self._view
        if (
            view.doing in (DutyStage.SIGNING_ON, DutyStage.STANDING, DutyStage.RUNNING)
            and view.duty is not None
        ):
            portal = view.duty.mission.spans[0].section_id
            ails = self._no_unit()
            if ails is not None:
                return replace(self._make(ails), section=portal), math.inf
            if view.signed_on:
                return self._portal(t_s, portal)
            wait, until_s = self._request(AwaitedRequest.SIGN_ON, t_s, (portal,))
            return replace(wait, section=wait.section or portal), until_s
        following = view.next_duty
        if following is None:
            return self._make(Cause.LEFT), math.inf
        train, portal = following.train.number, following.mission.spans[0].section_id
        if t_s < following.comes_s:
            late = t_s >= following.enter_s
            until_s = following.comes_s if late else following.enter_s
            cause = Cause.LATE if late else Cause.OUTSIDE
            return replace(self._make(cause), train=train, section=portal, until_s=until_s), until_s
        return self._before_its_number(following, t_s)

    def _before_its_number(self, following: Duty, t_s: float) -> tuple[Wait, float]:
        """At its portal: behind others, or its crew is yet to enter the train number."""
        portal = following.mission.spans[0].section_id
        wait = replace(self._make(Cause.QUEUE), train=following.train.number, section=portal)
        ahead = list(self._history.ahead(following, self._drawn))
        queues_until_s = max((s for comes_s, s in ahead if comes_s <= t_s < s), default=t_s)
        if queues_until_s > t_s:
            return wait, queues_until_s
        until_s = min((comes_s for comes_s, _ in ahead if comes_s > t_s), default=math.inf)
        return replace(wait, cause=self._no_unit() or Cause.NUMBER), until_s

    def _portal(self, t_s: float, portal: str) -> tuple[Wait, float]:
        """Signed on, before its portal: a train stands there, or its crew takes it in."""
        view, pieces = self._view, self._setup.line.pieces
        for other in self._drawn:
            at = self._where.piece(other, t_s)
            there = at is not None and pieces[at[0]].section_id == portal
            if other != view.unit and there and self._history.on_line(other, t_s):
                return replace(self._make(Cause.PORTAL), section=portal, since_s=view.signed_on_s), math.inf
        return replace(self._make(Cause.ENTRY), section=portal), math.inf

    # on the line ----------------------------------------------------------------------------------------------

    def _boarding(self, t_s: float) -> tuple[Wait, float] | None:
        """People hold the doors open, which the unit sees as doors that are not closed."""
        view = self._view
        if view.unfit != DOORS_OPEN or not view.powered or t_s >= view.doors_until_s:
            return None
        return replace(self._make(Cause.DWELL), until_s=view.doors_until_s), view.doors_until_s

    def _no_unit(self) -> Cause | None:
        """Why the unit does nothing, if so."""
        view, number = self._view, Cause.NUMBER if self._view.numberless else None
        if view.by_hand:
            return Cause.BY_HAND
        return Cause.UNIT_OFF if not view.powered else Cause.UNIT_FROZEN if view.frozen else number

    def _out_of_order(self) -> tuple[Wait, float] | None:
        view = self._view
        ails = self._no_unit()
        if ails is not None:
            return self._make(ails), math.inf
        if view.mismatch:
            return replace(self._make(Cause.CONTRADICTION), reason=view.mismatch, party=MANAGER), math.inf
        if view.unfit or view.unable:
            cause = Cause.VEHICLE if view.unfit else Cause.UNABLE
            return replace(self._make(cause), reason=view.unfit or view.unable), math.inf
        if view.emergency and view.doing in (DutyStage.RUNNING, DutyStage.ON_SIGHT):
            return self._make(Cause.EMERGENCY), math.inf
        return None

    def _by_duty(self, t_s: float) -> tuple[Wait, float]:
        view = self._view
        if view.doing is DutyStage.SIGNING_ON or (view.doing is DutyStage.ON_SIGHT and not view.signed_on):
            return self._request(AwaitedRequest.SIGN_ON, t_s)
        match view.doing:
            case DutyStage.SIGNING_OFF | DutyStage.GONE:
                return self._signing_off(t_s)
            case DutyStage.FINISHED | DutyStage.NOTHING:
                return self._finished()
            case DutyStage.ON_SIGHT if view.departed:
                return self._on_sight(t_s)
            case DutyStage.RUNNING:
                return self._held_up(t_s)
            case _:
                return self._at_stop(t_s)

    def _signing_off(self, t_s: float) -> tuple[Wait, float]:
        if AwaitedRequest.SIGN_OFF in self._view.requests:
            return self._request(AwaitedRequest.SIGN_OFF, t_s)
        cause = Cause.LEAVING if self._view.doing is DutyStage.GONE else Cause.SIGN_OFF
        return self._make(cause), math.inf

    def _finished(self) -> tuple[Wait, float]:
        """Between two trains: the driver changes ends, or the crew takes up the next number."""
        view, following = self._view, self._view.next_duty
        if following is None or view.duty is None:
            return self._make(Cause.STABLED), math.inf
        turns = following.mission.direction is not view.duty.mission.direction
        train = following.train.number
        return replace(self._make(Cause.TURN_BACK if turns else Cause.NEXT_TRAIN), reason=train), math.inf

    def _at_stop(self, t_s: float) -> tuple[Wait, float]:
        """At a stop: the dwell, the departure time, then the way ahead."""
        view = self._view
        targets = () if view.duty is None else view.duty.mission.targets
        if view.departed and view.doing is DutyStage.STANDING:
            return self._make(Cause.STARTING), math.inf
        if view.at >= len(targets) - 1:
            return self._ends_here(t_s)
        planned_s = targets[view.at].departure_s
        shown_s = -math.inf if planned_s is None else view.shown_at_s(planned_s)
        leave_s = max(shown_s, view.ready_s)
        if t_s < leave_s and view.ready_s >= shown_s and view.dwells:
            return replace(self._make(Cause.DWELL), until_s=leave_s), leave_s
        if t_s < leave_s and planned_s is not None:
            why = "" if targets[view.at].passengers else NO_PASSENGERS
            why = why if shown_s == planned_s else WRONG_CLOCK
            return replace(self._make(Cause.DEPARTURE_TIME), until_s=planned_s, reason=why), leave_s
        if view.emergency:
            return self._make(Cause.EMERGENCY), math.inf
        return self._on_sight(t_s) if view.doing is DutyStage.ON_SIGHT else self._way_ahead(t_s)

    def _ends_here(self, t_s: float) -> tuple[Wait, float]:
        """At its last stop, before its journey counts as done."""
        if AwaitedRequest.REPORT in self._view.requests:
            return self._request(AwaitedRequest.REPORT, t_s)
        if self._view.doing is DutyStage.ON_SIGHT:
            return self._make(Cause.ON_SIGHT), math.inf
        return self._make(Cause.ARRIVAL_BY_EYE), math.inf

    def _held_up(self, t_s: float) -> tuple[Wait, float]:
        """Has left its stop and stands: it just starts, or its stop limit holds it."""
        stands_at_stop = self._stretch.phase in AT_ITS_STOP
        if stands_at_stop:
            return self._make(Cause.STARTING), math.inf
        return self._way_ahead(t_s) if self._limit_is_near(t_s) else self._starts(t_s)

    def _starts(self, t_s: float) -> tuple[Wait, float]:
        """Its way is free: it starts, but for a level crossing ahead."""
        crossing, until_s = self._view.crossing_ahead(self._here(t_s), t_s)
        if not crossing:
            return self._make(Cause.STARTING), math.inf
        asked = self._view.crossings[crossing]
        wait = self._make(Cause.LEVEL_CROSSING)
        return replace(wait, party=crossing, since_s=asked.since_s, reason=asked.lost), until_s

    def _on_sight(self, t_s: float) -> tuple[Wait, float]:
        view = self._view
        if view.crew_waits_at:
            wait, until_s = self._points(t_s, view.crew_waits_at)
            moves = wait.cause is Cause.POINTS_MOVE
            return replace(wait, cause=wait.cause if moves else Cause.POINTS_BY_EYE), until_s
        if AwaitedRequest.ROUTE in view.requests:
            return self._request(AwaitedRequest.ROUTE, t_s, self._route_sections(view.limit_before))
        return self._make(Cause.ON_SIGHT), math.inf

    # what is ahead --------------------------------------------------------------------------------------------

    def _limit_is_near(self, t_s: float) -> bool:
        """Whether the stop limit lies as near before the front as a train stands before one."""
        view = self._view
        here = self._here(t_s)
        if view.limit_before is None or view.limit_at is None or here is None:
            return False
        return abs(view.limit_at[1] - here[1]) <= 1.0 + 2.0 * self._setup.unit.standoff_m

    def _way_ahead(self, t_s: float) -> tuple[Wait, float]:
        view = self._view
        if view.limit_why == NOT_PROVEN and view.limit_before is not None:
            missing = self._points_missing(view.limit_before)
            return self._points(t_s, missing) if missing else self._starts(t_s)
        if AwaitedRequest.ROUTE in view.requests:
            return self._request(AwaitedRequest.ROUTE, t_s, self._route_sections(view.limit_before))
        if view.set_back:
            return self._make(Cause.SET_BACK), math.inf
        if AwaitedRequest.REPORT in view.requests:
            return self._request(AwaitedRequest.REPORT, t_s)
        if view.limit_before is None:
            return self._starts(t_s)
        return self._request(AwaitedRequest.ROUTE, t_s, self._route_sections(view.limit_before))

    def _route_sections(self, before: str | None) -> tuple[str, ...]:
        """Sections of the route of the present train that has a section."""
        routes = () if self._view.duty is None else self._view.duty.mission.routes
        return next(
            (r.section_ids for r in routes if before in r.section_ids), () if before is None else (before,)
        )

    def _request(
        self, asked: AwaitedRequest, t_s: float, sections: tuple[str, ...] = ()
    ) -> tuple[Wait, float]:
        """An open request: who has what was asked for, why it was refused, or that no answer has come."""
        request = self._view.requests.get(asked)
        changes_s = self._history.next_change_s(sections, t_s)
        ails, ails_until_s = self._history.ails(MANAGER, t_s)
        until_s = min(changes_s, ails_until_s)
        wait = replace(self._make(Cause.ANSWER), asked=asked, party=MANAGER)
        if request is None or not self._covered(t_s):
            cause = Cause.ANSWER if self._covered(t_s) else Cause.COVERAGE
            return replace(wait, cause=cause), until_s
        if ails or self._view.cable_cut:
            return replace(wait, since_s=request.since_s, reason=ails or CABLE_CUT), until_s
        for section in sections:
            holder = self._history.holder(section, t_s, self._view.unit)
            if holder is not None and request.refusal.startswith(HELD_REASON):
                return self._held(asked, section, holder.unit, holder.from_s, holder.to_s, t_s), until_s
        for reason, cause in NOT_NOW.items():
            if request.refusal.startswith(reason):
                return self._behind(cause, asked, request), until_s
        if request.refusal.startswith(HELD_REASON):  # nobody has it any more: it asks again in a moment
            return replace(wait, reason=ASKS_AGAIN), until_s
        cause = Cause.REFUSED if request.refusal else Cause.ANSWER
        return replace(wait, cause=cause, since_s=request.since_s, reason=request.refusal), until_s

    def _behind(self, cause: Cause, asked: AwaitedRequest, request: WaitingRequest) -> Wait:
        """Its way is free, but another is to come first: that, and where to, the refusal names last."""
        _, _, named = request.refusal.partition(": section ")
        section, _, unit = named.partition(" of ")
        train, since_s = self._history.train_of(unit, request.since_s), request.since_s
        return replace(
            self._make(cause), asked=asked, section=section, party=unit, party_train=train, since_s=since_s
        )

    def _held(
        self, asked: AwaitedRequest, section: str, unit: str, from_s: float, to_s: float, t_s: float
    ) -> Wait:
        return replace(
            self._make(Cause.ROUTE_HELD),
            asked=asked,
            section=section,
            party=unit,
            party_train=self._history.train_of(unit, t_s),
            since_s=from_s,
            until_s=None if to_s == math.inf else to_s,
        )

    def _points_missing(self, section: str) -> str:
        """The first points of a section that are not proven as the present train needs them."""
        spans = () if self._view.duty is None else self._view.duty.mission.spans
        needed = [points for span in spans if span.section_id == section for points, _, _ in span.points]
        return next((points for points in needed if points not in self._view.proven), "")

    def _points(self, t_s: float, points: str) -> tuple[Wait, float]:
        """Points that are not proven: they move, were refused, or their terminal says nothing."""
        view, item = self._view, self._setup.line.points[points]
        moves, since_s, until_s = self._history.points_move(points, t_s)
        ails, ails_until_s = self._history.ails(item.terminal_id, t_s)
        until_s = min(until_s, ails_until_s)
        wait = self._make(Cause.POINTS_PROOF)
        wait = replace(wait, points=points, section=view.limit_before or "", party=item.terminal_id)
        if ails or self._view.cable_cut:
            return replace(wait, reason=ails or CABLE_CUT), until_s
        if points in view.points_refused:
            return replace(wait, cause=Cause.POINTS_REFUSED, reason=view.points_refused[points]), until_s
        if moves:
            return replace(wait, cause=Cause.POINTS_MOVE, since_s=since_s), until_s
        since_s = view.commanded_s.get(item.terminal_id, math.nan)
        if not math.isnan(since_s):
            return replace(wait, since_s=since_s), until_s
        return wait if self._covered(t_s) else replace(wait, cause=Cause.COVERAGE), until_s

    def _covered(self, t_s: float) -> bool:
        """Whether the radio reaches the train where it stands; a train outside stands where it is."""
        at = self._here(t_s)
        if self._stretch.phase is None or at is None:
            return True
        line, (piece, at_m) = self._setup.believed_line, at
        alignment = line.alignments[line.pieces[piece].alignment_id]
        return any(x.from_m <= at_m <= x.to_m for x in alignment.coverage)

    # running --------------------------------------------------------------------------------------------------

    def _runs(self, from_s: float, to_s: float) -> Iterator[Wait]:
        """Runs; from where to where a stop limit short of its next mark slows it down."""
        slowed = self._slowed(from_s, to_s)
        runs = replace(self._make(Cause.RUNS), at_m=None)
        if slowed is None:
            yield replace(runs, from_s=from_s, to_s=to_s)
            return
        begins_s, ends_s = slowed
        if begins_s > from_s:
            yield replace(runs, from_s=from_s, to_s=begins_s)
        at_s = begins_s
        while at_s < ends_s:
            why, until_s = self._way_ahead(at_s)
            next_s = min(ends_s, until_s) if until_s > at_s else ends_s
            reason = "" if why.cause in {Cause.STARTING, Cause.LEVEL_CROSSING} else why.cause.value
            at_m = None if self._view.limit_at is None else self._view.limit_at[1]
            section = self._view.limit_before or ""
            what = replace(why, cause=Cause.STOP_LIMIT, section=section, place="", at_m=at_m, reason=reason)
            yield replace(what, from_s=at_s, to_s=next_s)
            at_s = next_s
        if ends_s < to_s:
            yield replace(runs, from_s=ends_s, to_s=to_s)

    def _slowed(self, from_s: float, to_s: float) -> tuple[float, float] | None:
        """When its stop limit holds it back, s: since it had to brake for that, until it pulls again; None: never."""
        view, driving = self._view, self._setup.driving
        goes_on, self._held_back_by = (
            self._held_back_by is not None and self._held_back_by == view.limit_at,
            None,
        )
        if view.limit_before is None or view.limit_at is None or view.duty is None or not self._is_short():
            return None
        if view.limit_at[0] not in view.duty.mission.path:
            return None  # on another track than planned, whose limit its planned way does not have
        limit_m = view.duty.mission.path.to_path_m(*view.limit_at)
        rows = self._where.samples(view.unit, from_s, to_s)
        times_s = rows["step"] / STEPS_PER_S
        left_m = np.maximum(limit_m - rows["position_m"] - self._setup.unit.standoff_m, 1.0)
        needed_mps2 = rows["speed_mps"] ** 2 / (2.0 * left_m)
        near = needed_mps2 >= SLOWED_SHARE * driving.stop_deceleration_mps2
        brakes = (rows["acceleration_mps2"] <= BRAKES_MPS2) & (rows["notch"] < 0.0)
        begins = times_s[near & brakes & (rows["position_m"] < limit_m)]
        if not goes_on and not begins.size:
            return None
        begins_s = from_s if goes_on or begins[0] - from_s < SAMPLES_S else float(begins[0])
        pulls = times_s[~near & (rows["notch"] > 0.0) & (times_s > begins_s)]
        if not pulls.size:
            self._held_back_by = view.limit_at
        ends_s = float(pulls[0]) if pulls.size else to_s
        return (begins_s, ends_s) if begins_s < ends_s else None

    def _is_short(self) -> bool:
        """Whether the stop limit lies before the mark of the next stop."""
        view = self._view
        if view.duty is None or view.limit_before is None:
            return False
        mission = view.duty.mission
        following = mission.targets[min(view.at + 1, len(mission.targets) - 1)]
        sections = [span.section_id for span in mission.spans]
        if view.limit_before not in sections:
            return False
        return sections.index(view.limit_before) <= sections.index(following.section_id)


def _join(found: list[Wait], more: Iterable[Wait]) -> None:
    """Append waits; one that says the same as the last goes on with it."""
    for wait in more:
        last = found[-1] if found else None
        if last is not None and replace(last, to_s=wait.to_s) == replace(wait, from_s=last.from_s):
            found[-1] = replace(last, to_s=wait.to_s)
        else:
            found.append(wait)
