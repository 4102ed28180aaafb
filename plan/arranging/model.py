"""The nearest plan as a constraint model: CP-SAT, one worker, counted work, so that the answer is the same anywhere.

Trains never leave before their printed time. What lies between two places, and every track, is one train's at a time;
of tracks that a train may have, one is chosen. The sum of all moves of printed times is least; a move beyond what is
allowed counts a thousandfold, so that where nothing else works the least that would do is found.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import pairwise
from typing import Final

from ortools.sat.python import cp_model

from plan.arranging.problem import (
    Arranged,
    ArrangedVisit,
    ByStanding,
    Leg,
    PrintedMove,
    Standing,
    TrainToArrange,
    Visit,
)
from plan.arranging.telling import FoundSoFar, Tell
from plan.arranging.windows import windows_s

SEED: Final = 1
REACH_S: Final = 4 * 3600  # assumed: nobody would call it the same train that is moved by more
EARLY_S: Final = 60  # an arrival may be this much before its print: nobody gets on
PRESOLVED_S: Final = (
    1200  # as found: with more room for moves presolve took a minute once, otherwise less than a second
)
SECOND: Final = 20  # weight of a second
EARLY_COST: Final = (
    1  # more for one by which an arrival is early: of two plans the one that keeps to the minute
)
STOP_COST: Final = 5  # a stop that no source prints, where it saves nothing
TRACK_COST: Final = 1  # a track that is not the usual one
BEYOND_COST: Final = 1000 * SECOND
# assumed: a track more is worth ten minutes in all beyond what is allowed
MORE_COST: Final = 600 * BEYOND_COST
SLOWER_SHARE: Final = (
    0.25  # how much longer a run may take that ends in running through, so that it need not stop
)
DAY_BEGINS_S: Final = -3600
NIGHT_S: Final = 3600  # after the last train, in which sets stand over
PORTAL_S: Final = 180  # assumed: from a portal to leaving the station behind it, with the stop there, or back
ANOTHER: Final = "+"  # stands for the section of a track that a station does not have
BEYOND_TEXT: Final = f", a second beyond the limit as {BEYOND_COST // SECOND}"
EXCLUSIVE = True  # off: a section is anybody's at any time

IntVar = cp_model.IntVar


class NoRoomError(ValueError):
    """No plan: mostly sets that stand over have no tracks. `certain`: there is none, not only that none was found.

    `bound_s`: below which there is none, as in `Arranged`.
    """

    def __init__(self, why: str, *, certain: bool = True, work: float = 0.0, bound_s: float = 0.0) -> None:
        super().__init__(why)
        self.certain: Final = certain
        self.work: Final = work
        self.bound_s: Final = bound_s


class Aim(Enum):
    """What is looked for: the least, with its bound; any plan; one with the fewest tracks more; a better one."""

    LEAST = "least"
    ANY = "any"
    FEWEST = "fewest"
    BETTER = "better"


@dataclass(slots=True)
class _VisitVars:
    visit: Visit
    arrives: IntVar | int  # a number: it is settled
    departs: IntVar | int
    stands: IntVar | None  # None: it is settled
    tracks: dict[str, IntVar] = field(default_factory=dict[str, IntVar])


class ArrangeModel:
    """The variables of a problem and what holds between them.

    `limit_s`: printed times may be moved by so much; `reach_s`: and are moved by so much at most, where they must be.
    `more_tracks`: how many tracks stations may be given that they do not have, each at a price. `laid`: stations
    that have one of two tracks until they are given the other, at the same price.
    `settled`: visits of trains that keep their times and tracks; the others are arranged around them.
    """

    def __init__(
        self,
        trains: Sequence[TrainToArrange],
        limit_s: int,
        reach_s: int,
        more_tracks: Mapping[str, int] | None = None,
        settled: Mapping[str, Sequence[ArrangedVisit]] | None = None,
        laid: Collection[str] = (),
    ) -> None:
        self._settled_at: Final = settled or {}
        self.model: Final = cp_model.CpModel()
        self._more_max: Final = more_tracks or {}
        self._laid: Final = laid
        self._on_more: dict[str, list[cp_model.IntervalVar]] = defaultdict(list)
        self._more: dict[str, IntVar] = {}
        self._limit_s = limit_s
        self._reach_s = reach_s
        self._held: dict[str, list[tuple[object, cp_model.IntervalVar]]] = defaultdict(list)
        self._cost: list[cp_model.LinearExpr | IntVar] = []
        self._move_costs: list[cp_model.LinearExpr | IntVar] = []  # as in `search.cost_of`
        self._moves: list[tuple[TrainToArrange, Visit, str, int, IntVar | int]] = []
        self._windows: Final = {train.number: windows_s(train, reach_s) for train in trains}
        # sets that stand over stand there after all trains have come, whatever they wait for on their way
        last_s = [own[-1][2] for own in self._windows.values()]
        last_s += [own[-1].departure_s for own in self._settled_at.values()]
        self._ends_s = max(last_s) + NIGHT_S
        self.vars: Final = {
            train.number: _settled_vars(train, self._settled_at[train.number])
            if train.number in self._settled_at
            else self._train(train)
            for train in trains
        }
        self._trains: Final = {train.number: train for train in trains}
        becomes = {train.follows: train for train in trains if train.follows is not None}
        for train in trains:
            if train.follows is not None and not self._settled_at.keys() >= {train.follows, train.number}:
                before, first = self.vars[train.follows][-1], self.vars[train.number][0]
                self.model.add(first.departs >= before.arrives + train.turn_s)
            self._hold(train, becomes.get(train.number))
        self._exclude()
        self._move_costs += [MORE_COST * count for count in self._more.values()]
        self.model.minimize(sum([*self._cost, *self._move_costs]))

    # times ------------------------------------------------------------------------------------------------------------

    def _train(self, train: TrainToArrange) -> list[_VisitVars]:
        found: list[_VisitVars] = []
        windows = zip(train.visits, self._windows[train.number], strict=True)
        for index, (visit, (comes_s, leaves_s, to_s)) in enumerate(windows):
            name = f"{train.number} {visit.station_id}"
            arrives = self.model.new_int_var(comes_s, to_s, f"{name} a")
            departs = self.model.new_int_var(leaves_s, to_s, f"{name} d")
            stands = self.model.new_bool_var(f"{name} stands") if visit.standing is Standing.MAY else None
            one = _VisitVars(visit, arrives, departs, stands)
            for track in visit.tracks if len(visit.tracks) > 1 else ():
                one.tracks[track] = self.model.new_bool_var(f"{name} {track}")
            self._stay(one, last=index in (0, len(train.visits) - 1))
            if found:
                self._run(found[-1], one)
            self._print(train, one)
            found.append(one)
        return found

    def _stay(self, one: _VisitVars, *, last: bool) -> None:
        visit = one.visit
        if last or visit.standing is Standing.ALWAYS:
            self.model.add(one.departs >= one.arrives + (0 if last else visit.stay_s))
        elif one.stands is None:
            self.model.add(one.departs == one.arrives)
        else:
            self.model.add(one.departs >= one.arrives + visit.stay_s).only_enforce_if(one.stands)
            self.model.add(one.departs == one.arrives).only_enforce_if(~one.stands)
            self._cost.append(STOP_COST * one.stands)

    def _run(self, before: _VisitVars, one: _VisitVars) -> None:
        """The run there takes its time; one that ends in running through does not dawdle."""
        for from_stands, to_stands, run_s in one.visit.run.ways() if one.visit.run is not None else ():
            if not (before.visit.can(from_stands) and one.visit.can(to_stands)):
                continue
            literals = [*_if(before, stands=from_stands), *_if(one, stands=to_stands)]
            longer = _longer(before, stands=from_stands, leaves=True)
            departs = sum([*longer, *_longer(one, stands=to_stands, leaves=False)], start=before.departs)
            self.model.add(one.arrives >= departs + run_s).only_enforce_if(literals)
            if not to_stands:
                slowest_s = run_s + round(SLOWER_SHARE * run_s)
                self.model.add(one.arrives <= departs + slowest_s).only_enforce_if(literals)

    def _print(self, train: TrainToArrange, one: _VisitVars) -> None:
        visit = one.visit
        if visit.departure_s is not None:
            self._count(train, visit, "departure", visit.departure_s, one.departs)
        if visit.arrival_s is not None:
            self.model.add(one.arrives >= visit.arrival_s - EARLY_S)
            self._count(train, visit, "arrival", visit.arrival_s, one.arrives)

    def _count(
        self, train: TrainToArrange, visit: Visit, what: str, printed_s: int, at: IntVar | int
    ) -> None:
        name = f"{train.number} {visit.station_id} {what}"
        late = self.model.new_int_var(0, self._reach_s, f"{name} late")
        self.model.add(late >= at - printed_s)
        moved = [late]
        if what == "arrival":
            early = self.model.new_int_var(0, EARLY_S, f"{name} early")
            self.model.add(early >= printed_s - at)
            self._move_costs.append(EARLY_COST * early)
            moved.append(early)
        self._move_costs += [SECOND * by for by in moved]
        for by in moved if self._reach_s > self._limit_s else ():
            beyond = self.model.new_int_var(0, self._reach_s, f"{name} beyond")
            self.model.add(beyond >= by - self._limit_s)
            self._move_costs.append(BEYOND_COST * beyond)
        self._moves.append((train, visit, what, printed_s, at))

    # what is held -----------------------------------------------------------------------------------------------------

    def _hold(self, train: TrainToArrange, becomes: TrainToArrange | None) -> None:
        """The ways between places, and the tracks at their ends."""
        own = self.vars[train.number]
        places = [i for i, one in enumerate(own) if one.visit.tracks]
        for here, there in pairwise(places):
            leg = own[there].visit.leg
            if leg is None:
                raise ValueError(f"{train.number}: no leg to {own[there].visit.station_id}")
            way = self._interval(f"{train.number} {here}", self._from(own, here, there), self._to(own, there))
            for section_id in leg.section_ids:
                self._held[section_id].append((train.number, way))
            self._come_in(f"{train.number} {there} in", own[there], leg)
        for at, here in enumerate(places):
            if at == 0 and train.follows is not None:
                continue  # its set stands there since the train before
            begin: Bound = DAY_BEGINS_S
            if at:
                begin = self._from(own, places[at - 1], here)
            elif train.enters is not None:
                begin = own[here].departs - PORTAL_S
                self._pass(train.number, train.enters, begin, own[here].departs)
            stays: list[_VisitVars] = [own[here]]
            if at + 1 < len(places):
                end = self._to(own, places[at + 1])
            elif becomes is not None:
                theirs = self.vars[becomes.number]
                their_places = [i for i, one in enumerate(theirs) if one.visit.tracks]
                stays.append(theirs[their_places[0]])
                end = self._to(theirs, their_places[1])
            elif train.leaves is not None:
                end = own[here].arrives + PORTAL_S
                self._pass(train.number, train.leaves, own[here].arrives, end)
            else:
                end = self._ends_s
            self._stand(f"{train.number} {here} track", begin, end, stays)

    def _pass(self, number: str, portal: str, begin: Bound, end: Bound) -> None:
        """A portal is one train's at a time, that comes or goes."""
        self._held[portal].append((number, self._interval(f"{number} {portal}", begin, end)))

    def _come_in(self, name: str, one: _VisitVars, leg: Leg) -> None:
        """What a train has alone as it comes in, where opposing ones may not do so at once."""
        if leg.overlaps:
            enters = ByStanding(-leg.enters.stands, -leg.enters.passes)
            begin, end = (self._shifted(one.arrives, one, by) for by in (enters, leg.stood))
            interval = self._interval(name, begin, end)
            for overlap in leg.overlaps:
                self._held[overlap].append((name, interval))

    def _stand(self, name: str, begin: Bound, end: Bound, stays: Sequence[_VisitVars]) -> None:
        """One of the tracks for as long as the train, or its set, is there; the same for all its calls there."""
        if stays[0].visit.station_id in self._laid:
            self._on_more[stays[0].visit.station_id].append(self._interval(f"{name} one of two", begin, end))
        if any(ANOTHER in stay.visit.tracks for stay in stays):
            for here in (here for stay in stays for here in stay.tracks.values()):
                self.model.add(here == 0)
            self._on_more[stays[0].visit.station_id].append(self._interval(f"{name} another", begin, end))
            return
        allowed = [t for t in stays[0].visit.tracks if all(t in stay.visit.tracks for stay in stays)]
        if not allowed:
            raise NoRoomError(f"no track at {stays[0].visit.station_id} serves {name}")
        free = None
        if self._more_max.get(stays[0].visit.station_id):
            free = self._on_another(name, stays[0].visit.station_id, begin, end)
        chosen = dict(stays[0].tracks)
        if not chosen:
            chosen[allowed[0]] = self.model.new_bool_var(f"{name} {allowed[0]}")
            for stay in stays:
                stay.tracks = stay.tracks or dict(chosen)
        self.model.add_exactly_one([*(chosen[track] for track in allowed), *([] if free is None else [free])])
        for stay in stays:
            for track, here in stay.tracks.items():
                self.model.add(here == (chosen[track] if track in allowed else 0))
        for rank, track in enumerate(allowed):
            self._held[track].append((name, self._optional(f"{name} {track}", begin, end, chosen[track])))
            if rank:
                self._cost.append(TRACK_COST * chosen[track])

    def _on_another(self, name: str, station_id: str, begin: Bound, end: Bound) -> IntVar:
        """Whether it stands on a track that the station does not have."""
        chosen = self.model.new_bool_var(f"{name} another")
        self._on_more[station_id].append(self._optional(f"{name} another", begin, end, chosen))
        return chosen

    def _from(self, own: Sequence[_VisitVars], here: int, there: int) -> Bound:
        leg = own[there].visit.leg
        lead = ByStanding(0, 0) if leg is None else leg.lead
        return self._shifted(own[here].departs, own[here], ByStanding(-lead.stands, -lead.passes))

    def _to(self, own: Sequence[_VisitVars], there: int) -> Bound:
        leg = own[there].visit.leg
        return self._shifted(own[there].arrives, own[there], ByStanding(0, 0) if leg is None else leg.lag)

    def _shifted(self, at: IntVar | int, one: _VisitVars, by: ByStanding) -> Bound:
        if one.stands is None or by.stands == by.passes or isinstance(at, int):
            return at + (by.passes if one.visit.standing is Standing.NEVER else by.stands)
        bound = self.model.new_int_var(DAY_BEGINS_S, self._ends_s, f"{at.name} held")
        self.model.add(bound == at + by.stands).only_enforce_if(one.stands)
        self.model.add(bound == at + by.passes).only_enforce_if(~one.stands)
        return bound

    def _interval(self, name: str, begin: Bound, end: Bound) -> cp_model.IntervalVar:
        if isinstance(begin, int) and isinstance(end, int):
            return self.model.new_fixed_size_interval_var(begin, end - begin, name)
        size = self.model.new_int_var(0, 2 * self._ends_s, f"{name} size")
        return self.model.new_interval_var(begin, size, end, name)

    def _optional(self, name: str, begin: Bound, end: Bound, chosen: IntVar) -> cp_model.IntervalVar:
        size = self.model.new_int_var(0, 2 * self._ends_s, f"{name} size")
        return self.model.new_optional_interval_var(begin, size, end, chosen, name)

    def _exclude(self) -> None:
        """One train at a time; sections that are always held together are looked at once."""
        seen: set[tuple[int, ...]] = set()
        for held in self._held.values():
            key = tuple(sorted(interval.index for _, interval in held))
            if EXCLUSIVE and len(held) > 1 and key not in seen:
                seen.add(key)
                self.model.add_no_overlap([interval for _, interval in held])
        for station_id, intervals in self._on_more.items():
            has = int(station_id in self._laid)
            count = self._more[station_id] = self.model.new_int_var(
                0, 1 if has else self._more_max[station_id], f"{station_id} more"
            )
            self.model.add_cumulative(intervals, [1] * len(intervals), count + has)

    def begin_with(self, visits: Mapping[str, Sequence[ArrangedVisit]]) -> None:
        """A plan to begin from."""
        for number, own in self.vars.items():
            for one, here in zip(own, visits[number], strict=True):
                if isinstance(one.arrives, int) or isinstance(one.departs, int):
                    continue
                self.model.add_hint(one.arrives, here.arrival_s)
                self.model.add_hint(one.departs, here.departure_s)
                if one.stands is not None:
                    self.model.add_hint(one.stands, here.stands)
                for track, chosen in one.tracks.items():
                    self.model.add_hint(chosen, track == here.track)

    # the answer -------------------------------------------------------------------------------------------------------

    def solve(
        self, work_max: float, aim: Aim = Aim.LEAST, below: int | None = None, tell: Tell | None = None
    ) -> Arranged:
        """The best plan that so much counted work finds; NoRoomError where there is none.

        `below`: and none that moves printed times by as much, weighted as in `cost_of`.
        """
        if aim is Aim.ANY:
            self.model.clear_objective()  # type: ignore[no-untyped-call]
            looked_for = [one for own in self.vars.values() for one in own]
            times = [at for one in looked_for for at in (one.arrives, one.departs) if not isinstance(at, int)]
            self.model.add_decision_strategy(times, cp_model.CHOOSE_LOWEST_MIN, cp_model.SELECT_MIN_VALUE)
        if aim is Aim.FEWEST:
            self.model.minimize(sum(self._more.values()))
        if below is not None:
            self.model.add(sum(self._move_costs) < below)
        solver = cp_model.CpSolver()
        solver.parameters.random_seed = SEED
        solver.parameters.num_workers = 1
        solver.parameters.max_deterministic_time = work_max
        # Orders decide and sums of moves relax badly: without linear programs, and from below, the proof comes sooner.
        solver.parameters.linearization_level = 0
        solver.parameters.optimize_with_core = aim in {Aim.LEAST, Aim.FEWEST}
        solver.parameters.core_minimization_level = 1
        # What is beyond the limit may be much of one time: the most of each conflict, not a second more and again.
        solver.parameters.cover_optimization = self._reach_s > self._limit_s
        # Precedences seen at once, not when a search has run into them: the proof then comes at all (decision 244).
        solver.parameters.use_strong_propagation_in_disjunctive = aim is not Aim.ANY
        # Trains that push each other through a wide reach second by second: presolve does not count such work.
        solver.parameters.cp_model_presolve = self._reach_s <= PRESOLVED_S
        # as a dispatcher does it: what can be first in the day is settled first, as soon as it can be
        if aim is Aim.ANY:
            solver.parameters.search_branching = cp_model.FIXED_SEARCH
        told = None
        if tell is not None and aim is Aim.LEAST:
            told = FoundSoFar(tell, SECOND, "" if self._reach_s == self._limit_s else BEYOND_TEXT)
            solver.best_bound_callback = told.on_bound
        status = solver.solve(self.model, told)
        work = solver.response_proto.deterministic_time
        bound_s = solver.best_objective_bound / SECOND if aim is Aim.LEAST else 0.0
        if status not in {cp_model.OPTIMAL, cp_model.FEASIBLE}:
            certain = status == cp_model.INFEASIBLE
            why = "no plan keeps all trains apart" if certain else "none was found"
            raise NoRoomError(why, certain=certain, work=work, bound_s=bound_s)
        visits = {number: self._settled(own, solver) for number, own in self.vars.items()}
        moves = tuple(
            PrintedMove(train.number, visit.station_id, what, printed_s, by_s)
            for train, visit, what, printed_s, at in self._moves
            if (by_s := solver.value(at) - printed_s)
        )
        return Arranged(
            visits,
            moves,
            status == cp_model.OPTIMAL and aim in {Aim.LEAST, Aim.FEWEST},
            bound_s,
            self._reach_s,
            work,
            {name: count for name, at in self._more.items() if (count := solver.value(at))},
        )

    def _settled(self, own: Sequence[_VisitVars], solver: cp_model.CpSolver) -> tuple[ArrangedVisit, ...]:
        found: list[ArrangedVisit] = []
        for one in own:
            stands = one.visit.standing is Standing.ALWAYS
            if one.stands is not None:
                stands = solver.boolean_value(one.stands)
            track = next((t for t, chosen in one.tracks.items() if solver.boolean_value(chosen)), None)
            if track is None and one.visit.tracks:
                track = ANOTHER if one.tracks else one.visit.tracks[0]
            found.append(
                ArrangedVisit(
                    one.visit.station_id, solver.value(one.arrives), solver.value(one.departs), stands, track
                )
            )
        return tuple(found)


Bound = cp_model.LinearExpr | IntVar | int


def _settled_vars(train: TrainToArrange, visits: Sequence[ArrangedVisit]) -> list[_VisitVars]:
    """Of a train that keeps what it has."""
    return [
        _VisitVars(
            replace(
                visit,
                standing=Standing.ALWAYS if here.stands else Standing.NEVER,
                tracks=(here.track,) if here.track else (),
            ),
            here.arrival_s,
            here.departure_s,
            None,
        )
        for visit, here in zip(train.visits, visits, strict=True)
    ]


def _if(one: _VisitVars, *, stands: bool) -> list[cp_model.LiteralT]:
    """The condition that a train stands (passes) there; nothing where that is settled."""
    if one.stands is None:
        return []
    return [one.stands if stands else ~one.stands]


def _longer(one: _VisitVars, *, stands: bool, leaves: bool) -> list[cp_model.LinearExpr]:
    """How much longer the run there (from there) takes on the track that is chosen, s, in parts."""
    longer = {track: one.visit.longer_s(track, stands=stands, leaves=leaves) for track in one.tracks}
    return [by_s * one.tracks[track] for track, by_s in longer.items() if by_s]
