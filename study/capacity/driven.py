"""How trains of a stock are driven by prediction: journeys made of the plan, with what clearing and braking need."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from network.clock import first_given
from onboard.driving.ahead import kept_along_mps
from onboard.driving.room import Room
from onboard.driving.stop_keeper import soft_end_s
from onboard.duty.timekeeping import cruise_for
from onboard.mission import Mission, Passing, Target
from onboard.plan import plan_of
from onboard.records import BehaviourRow
from onboard.unit_records import UnitParameters
from simulation.people import Pause
from simulation.setup import Setup, behaviour_row
from simulation.world.ways import path_database
from study.capacity.clearing import Clearing
from study.capacity.journey import JourneyStay, TrainJourney
from study.capacity.links import Links
from study.capacity.rules import Rules
from study.capacity.setting import Setting
from study.feasibility.planned import PlannedTrain
from vehicle.records import TrainRow
from vehicle.running_time import predicted_course
from vehicle.starting import Start, start_of
from vehicle.wheel import pulse_m

SOFT_END_COUNTS = True  # off: a stop is braked evenly until the train stands
BOUNDS_COUNT = True  # off: a limit that falls is met where it does, wherever the train may be
STEP_S = 0.1
HOP_LEAST_M = 0.05  # two marks nearer than this are one


@dataclass(frozen=True, slots=True)
class DrivenGround:
    """A mission by the metre: climb, m; the speed by which its unit reckons in time, and that which it keeps, m/s.

    The second one knows that a train brakes for a lower limit where its front may be at the furthest.
    """

    climb_m: NDArray[np.float64]
    driving_mps: NDArray[np.float64]
    kept_mps: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class StockDriving:
    """How one stock is driven: the train as its unit believes it to be, its rules, and the ways that it knows.

    `start`: from the word to leave until the train moves, and runs as predicted. `known`: hops already predicted.
    """

    setup: Setup
    stock_id: str
    rules: Rules
    links: Links
    train: TrainRow
    behaviour: BehaviourRow
    clearing: Clearing
    room: Room
    start: Start
    grounds: dict[tuple[str, ...], DrivenGround]
    known: dict[tuple[object, ...], NDArray[np.float64]]

    @property
    def unit(self) -> UnitParameters:
        """Times of the unit."""
        return self.setup.unit

    def journey(self, planned: PlannedTrain, setting: Setting, ready_s: float) -> TrainJourney:
        """A train of the plan whose stock is ready for it at a time, s."""
        duty, mission = planned.duty, planned.duty.mission
        plan = plan_of(mission, float(self.train.length_m))
        begins_s, leaves_s, asked_s = ready_s, ready_s, ready_s
        leg = plan.leg_beyond(plan.spans[0].section_id)
        asks_s: dict[str, float] = {}
        if duty.enters:
            begins_s, asked_s = self._signs_on(planned, setting, max(ready_s, duty.enter_s))
            ready_s = asked_s + self.setup.people.mean_s(Pause.ENTRY)
        leaves_s = max(ready_s, first_given(mission.targets[0].departure_s, ready_s))
        if leg is not None:
            asks_s[leg.route_id] = self._asks_s(mission.targets[0], asked_s, asked_s)
            leaves_s = max(leaves_s, setting.way_free_s(plan, leg, asks_s[leg.route_id]))
        stays = [JourneyStay(0, ready_s, leaves_s)]
        course = [np.array([[ready_s, mission.targets[0].mark_m, 0.0]])]
        for at, there in enumerate(mission.targets[1:], start=1):
            hop = self._hop(mission, at, stays[-1].departs_s)
            course.append(hop)
            stands_s = float(hop[-1, 0])
            if at + 1 == len(mission.targets):
                stays.append(JourneyStay(at, stands_s, stands_s))
                break
            free_s = stands_s + (self.unit.dwell_min_s if there.passengers else 0.0)
            leaves_s = free_s if self.rules.unslowed else max(free_s, first_given(there.departure_s, free_s))
            leg = plan.leg_beyond(there.section_id)
            if leg is not None and leg.route_id not in asks_s:
                asks_s[leg.route_id] = self._asks_s(there, stands_s, free_s)
                if not self.rules.late:
                    leaves_s = max(leaves_s, setting.way_free_s(plan, leg, asks_s[leg.route_id]))
            stays.append(JourneyStay(at, stands_s, leaves_s))
        journey = TrainJourney(
            self.stock_id,
            mission,
            plan,
            float(self.train.length_m),
            np.vstack(course),
            tuple(stays),
            begins_s,
            stays[-1].arrives_s,
            duty.enters,
            duty.leaves,
            asks_s,
        )
        return journey.ended(self._done_s(journey))

    def _signs_on(self, planned: PlannedTrain, setting: Setting, stands_s: float) -> tuple[float, float]:
        """When a stock at its portal since a time has its number, and is signed on, s: as soon or as late as it can."""
        people = self.setup.people
        begins_s = stands_s + people.mean_s(Pause.SIGN_ON)
        plan = plan_of(planned.duty.mission, float(self.train.length_m))
        leg = plan.leg_beyond(plan.spans[0].section_id)
        if self.rules.late and leg is not None:
            way_s = setting.way_free_s(plan, leg, 0.0)
            way_s = max(way_s, people.mean_s(Pause.ENTRY))  # set while the train comes in
            begins_s = max(begins_s, planned.stands[0].departs_s - way_s - self.links.ask_s)
        return begins_s, begins_s + self.links.ask_s

    def _asks_s(self, target: Target, stands_s: float, free_s: float) -> float:
        """When a unit that stands at a stop asks for the route beyond it; see `DutyStep.schedule`."""
        lead_s = self.unit.request_lead_s
        planned_s = -math.inf if target.departure_s is None else target.departure_s - lead_s
        return max(stands_s, free_s - lead_s, planned_s)

    def _done_s(self, journey: TrainJourney) -> float:
        """When a train has done with its number: it stands, and what it reports there is confirmed."""
        stands_s = journey.stays[-1].arrives_s
        reports_s = [s for s in self.clearing.reported_s(journey)[:-1] if not math.isinf(s)]
        if self.rules.by_section or max(reports_s, default=-math.inf) < stands_s:
            return stands_s
        return max(reports_s) + self.links.report_s + self.links.grant_s

    def _hop(self, mission: Mission, at: int, leaves_s: float) -> NDArray[np.float64]:
        """The course of the run to target `at` from the one before, which it leaves at a time; shape (n, 3)."""
        here, there = mission.targets[at - 1], mission.targets[at]
        if there.mark_m - here.mark_m < HOP_LEAST_M:
            return np.array([[leaves_s, there.mark_m, 0.0]])
        dues_s = [self._due_s(there, passing) for passing in (*there.passings, None)]
        key = (
            mission.path.piece_ids,
            at,
            *(None if due_s is None else round(due_s - leaves_s, 3) for due_s in dues_s),
        )
        if key not in self.known:
            self.known[key] = self._run(mission, at, [d if d is None else d - leaves_s for d in dues_s])
        later: NDArray[np.float64] = self.known[key] + np.array([leaves_s, 0.0, 0.0])
        return later

    def _run(self, mission: Mission, at: int, dues_s: list[float | None]) -> NDArray[np.float64]:
        """A hop from time 0 on; `dues_s`: when it aims to be at the stations that it passes, and at its stop."""
        here, there = mission.targets[at - 1], mission.targets[at]
        ground, slows = self._ground(mission), float(self.behaviour.settings.stop_deceleration_mps2)
        stock = self.train, self.setup.load.load_share_mean, ground.climb_m
        asked_s, at_s, position_m, speed_mps = 0.0, self.start.delay_s, here.mark_m, 0.0
        rows = [np.array([[0.0, position_m, 0.0], [at_s, position_m, 0.0]])]
        for passing, due_s in zip((*there.passings, None), dues_s, strict=True):
            until_m = math.inf if passing is None else passing.position_m
            cruise_mps = math.inf
            if due_s is not None:
                within_s = due_s - asked_s
                cruise_mps = cruise_for(
                    *stock, ground.driving_mps, position_m, there.mark_m, within_s, slows, speed_mps, until_m
                )
            ends = position_m, there.mark_m, cruise_mps, slows
            part: NDArray[np.float64] = predicted_course(
                *stock, ground.kept_mps, *ends, STEP_S, speed_mps, until_m
            )
            rows.append(part[1:] + np.array([at_s, 0.0, 0.0]))
            at_s, position_m, speed_mps = at_s + float(part[-1, 0]), float(part[-1, 1]), float(part[-1, 2])
            asked_s = at_s
        rows[-1][-1, 0] += soft_end_s(slows) if SOFT_END_COUNTS else 0.0
        return np.vstack(rows)

    def _due_s(self, there: Target, passing: Passing | None) -> float | None:
        """When the unit aims to be at its stop, or at the station that it runs through before; None: at no time."""
        if self.rules.unslowed:
            return None
        if passing is not None:
            return passing.time_s
        latest_s = None if there.arrival_s is None else there.latest_arrival_s(self.unit.dwell_min_s)
        return None if latest_s is None else latest_s - self.unit.time_margin_s

    def _ground(self, mission: Mission) -> DrivenGround:
        key = (*mission.path.piece_ids, str(mission.targets[0].mark_m))
        if key not in self.grounds:
            rows = path_database(self.setup.believed_line, mission.path, self.train, self.behaviour)
            climb_m, driving_mps = (np.ascontiguousarray(rows[name]) for name in ("climb_m", "driving_mps"))
            bounds_m = self.clearing.bounds_m(mission, np.arange(rows.size, dtype=np.float64))
            kept_mps = kept_along_mps(rows, self.behaviour, bounds_m) if BOUNDS_COUNT else driving_mps
            self.grounds[key] = DrivenGround(climb_m, driving_mps, kept_mps)
        return self.grounds[key]


def driving_of(setup: Setup, stock_id: str, rules: Rules, links: Links) -> StockDriving:
    """How a stock of a setup is driven."""
    row = setup.believed_train(stock_id).row
    train = row.view(np.recarray)[0]
    behaviour = behaviour_row(setup.driving, row[0]).reshape(1).view(np.recarray)[0]
    clearing = Clearing(
        setup.unit, pulse_m(train), by_section=rules.by_section, release=setup.operation.release
    )
    reaction_s = float(train.brake_dead_time_s + train.brake_lag_s)
    room = Room(behaviour, reaction_s, setup.unit.standoff_m)
    start = start_of(train, setup.load.load_share_mean, float(behaviour.standing_brake_notch), STEP_S)
    return StockDriving(setup, stock_id, rules, links, train, behaviour, clearing, room, start, {}, {})
