"""The stage of the checkers' tests: a loop with two points, acts in a row, and situations to begin from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType

from network.model import Position
from simulation import events
from simulation.judge.checkers import Checker, Checkers, GuaranteedBrake, PointsFacts
from simulation.judge.crossings import CrossingFacts
from simulation.judge.entering import TrackOverlap
from simulation.judge.liveness import LOOKS_EVERY_S, TrainAndDisplay
from simulation.judge.speed import LimitBetween, TrueLimits
from simulation.procedure import Regime, before_entry
from sumo_cfg.truth_map import NetEdge, NetMap

# W | stem1 -< normal1 - T1 - normal2 >- stem2 | B | E, and reverse1 - T2 - reverse2
PIECES = {
    **{"W": ("W", 300.0), "T1": ("T1", 260.0), "T2": ("T2", 260.0), "B": ("B", 500.0), "E": ("E", 300.0)},
    **{"stem1": ("P1", 10.0), "normal1": ("P1", 30.0), "reverse1": ("P1", 30.0)},
    **{"stem2": ("P2", 10.0), "normal2": ("P2", 30.0), "reverse2": ("P2", 30.0)},
}
CHAINS = ("W stem1 normal1 T1 normal2 stem2 B E", "stem1 reverse1 T2 reverse2 stem2")
JOINTS = tuple(joint for chain in CHAINS for joint in pairwise(chain.split()))
POINTS = {
    "1": PointsFacts("P1", "stem1", "normal1", "reverse1", Position.NORMAL),
    "2": PointsFacts("P2", "stem2", "normal2", "reverse2", Position.NORMAL),
}
TRAIN_M = 40.0
DESIGN = 0.8
# points 2 begin 60 m beyond a train's stop on T1
OVERLAPS = {"T1+": TrackOverlap(stops_at_m=200.0, overlap_m=100.0)}
PILOTS = {"B": before_entry(Regime.TELEPHONE)}
CROSSINGS = {  # in W and E, each 6 m of road, with barriers and without
    "W": CrossingFacts({"W+": 250.0, "W-": 44.0}, True, 25.0, 15.0),
    "E": CrossingFacts({"E+": 50.0, "E-": 244.0}, False, 20.0, 20.0),
}
LIMITS = TrueLimits({"E-": [LimitBetween(270.0, 280.0, 15.0)]}, {"A": 25.0, "B": 25.0}, margin_mps=2.0)
NO_CROSSINGS: Mapping[str, CrossingFacts] = MappingProxyType({})
CREEP_MPS = 15.0 / 3.6
BRAKE = GuaranteedBrake(deceleration_mps2=1.0, reaction_s=1.0, gravity_mps2=9.0)


def net() -> NetMap:
    """The loop above in both directions; `+` runs from W to E."""
    edges: dict[str, NetEdge] = {}
    for piece, (section, length_m) in PIECES.items():
        down = tuple(f"{high}+" for low, high in JOINTS if low == piece)
        up = tuple(f"{low}-" for low, high in JOINTS if high == piece)
        edges[f"{piece}+"] = NetEdge(f"{piece}+", piece, section, length_m, f"{piece}-", down)
        edges[f"{piece}-"] = NetEdge(f"{piece}-", piece, section, length_m, f"{piece}+", up)
    return NetMap(edges)


class Stage:
    """Checkers and a clock; each act takes one second."""

    def __init__(
        self, unit_ids: tuple[str, ...] = ("A", "B"), crossings: Mapping[str, CrossingFacts] = NO_CROSSINGS
    ) -> None:
        self.checkers = Checkers(
            net(),
            POINTS,
            unit_ids,
            dict.fromkeys(unit_ids, BRAKE),
            {},
            DESIGN,
            OVERLAPS,
            PILOTS,
            crossings,
            CREEP_MPS,
            LIMITS,
        )
        self.t_s = 0.0
        self.token = 0

    def entry(self, who: str, event: events.Event) -> Stage:
        self.t_s += 1.0
        self.checkers.journal(events.JournalEntry(self.t_s, who, event))
        return self

    def world(self, event: events.Event) -> Stage:
        return self.entry(events.WORLD, event)

    def accept(self, unit: str, *sections: str) -> Stage:
        return self.entry(
            events.MANAGER, events.Accepted(unit_id=unit, section_ids=sections, token=0, was="unknown")
        )

    def by_hand(self, unit: str, *sections: str) -> Stage:
        return self.entry(
            events.MANAGER, events.ConfirmedByHand(unit_id=unit, section_ids=sections, token=0, by="Sato")
        )

    def bar(self, unit: str) -> Stage:
        return self.entry(events.MANAGER, events.Barred(unit_id=unit, by="Sato"))

    def defined(self) -> Stage:
        return self.entry(events.MANAGER, events.PictureChanged(stage="defined", inputs=0))

    def free(self, unit: str, *sections: str) -> Stage:
        return self.entry(events.MANAGER, events.Freed(unit_id=unit, section_ids=sections))

    def outside(self, unit: str) -> Stage:
        return self.entry(events.MANAGER, events.Outside(unit_id=unit))

    def restart_manager(self) -> Stage:
        return self.entry(events.MANAGER, events.Started(epoch=2))

    def grant(self, unit: str, *sections: str, token: int | None = None) -> Stage:
        self.token = self.token + 1 if token is None else token
        granted = events.Granted(unit_id=unit, route_id="r", section_ids=sections, token=self.token)
        return self.entry(events.MANAGER, granted)

    def holds(self, unit: str, *sections: str) -> Stage:
        return self.entry(unit, events.Holds(section_ids=sections, token=self.token))

    def shut(self, crossing: str, closing_s: float, closed_s: float) -> Stage:
        """A level crossing warns, is closed after that time, and has been for the other when the next act begins."""
        self.world(events.CrossingLamps(crossing_id=crossing, lit=True))
        if closing_s:
            self.t_s += closing_s - 1.0
            self.world(events.CrossingBarriers(crossing_id=crossing, state=events.BarrierState.LOWERED))
        self.t_s += closed_s - 1.0
        return self

    def see(self, unit: str, *places: tuple[str, float], speed_mps: float = 10.0) -> Stage:
        for edge, front_m in places:
            self.t_s += 1.0
            self.checkers.observe(self.t_s, unit, edge, front_m, speed_mps)
        return self

    def put(self, unit: str, edge: str, front_m: float = 200.0, length_m: float = TRAIN_M) -> Stage:
        self.checkers.entered(unit, length_m, (edge,))
        return self.see(unit, (edge, front_m), speed_mps=0.0)

    def sign_on(self, unit: str, *sections: str) -> Stage:
        return self.accept(unit, *sections).holds(unit, *sections)

    def prove(self, unit: str, points: str, position: str, token: int | None = None) -> Stage:
        token = self.token if token is None else token
        return self.entry(unit, events.Proven(points_id=points, position=Position(position), token=token))

    def bounds(self, true_m: float, behind_m: float, ahead_m: float) -> Stage:
        self.checkers.bounds(self.t_s, "A", true_m, 1000.0, behind_m, ahead_m)
        return self

    def effect(self, receiver: str, epoch: int, sequence: int) -> Stage:
        return self.entry(
            receiver,
            events.TookEffect(
                source="S",
                receiver=receiver,
                epoch=epoch,
                sequence=sequence,
                kind="ClaimQuery",
                correlation=0,
            ),
        )

    def run_in(self) -> Stage:
        """A runs from W over the normal leg into T1."""
        return self.see("A", ("stem1+", 5.0), ("normal1+", 20.0), ("T1+", 1.0), ("T1+", 50.0))

    def turn(self, unit: str) -> Stage:
        self.checkers.reversed(self.t_s, unit)
        return self

    def leave(self, unit: str) -> Stage:
        self.checkers.train_left(unit)
        return self

    def stand(self, for_s: float, *, timer: bool) -> Stage:
        """A stands and waits for its route; a timer of its unit runs, or none."""
        until_s = self.t_s + for_s
        while self.t_s < until_s:
            self.t_s += LOOKS_EVERY_S
            seen = TrainAndDisplay(
                "A", "section W", True, 0.0, timer, pulls=False, awaits=False, waits_for="route W>T1"
            )
            self.checkers.alive(self.t_s, [seen])
        return self

    def finish(self, **arrived: bool) -> Stage:
        self.checkers.finish(self.t_s, arrived)
        return self

    def broken(self) -> set[str]:
        return {violation.checker for violation in self.checkers.violations}


def authorised(
    unit_ids: tuple[str, ...] = ("A", "B"), crossings: Mapping[str, CrossingFacts] = NO_CROSSINGS
) -> Stage:
    """A stands in the portal W and may run to T1, points 1 proven in normal."""
    stage = Stage(unit_ids, crossings).put("A", "W+").sign_on("A", "W").grant("A", "P1", "T1")
    return stage.holds("A", "W", "P1", "T1").prove("A", "1", "normal")


def at_crossings() -> Stage:
    """A may run on in W up to T1; B stands in E, and may run within it."""
    return second(authorised(crossings=CROSSINGS))


def on_points(crossings: Mapping[str, CrossingFacts] = NO_CROSSINGS) -> Stage:
    """A has its front on the normal leg and its rear still in W: 10 + 20 of its 40 m are on the points."""
    return authorised(crossings=crossings).see("A", ("stem1+", 5.0), ("normal1+", 20.0))


def in_track() -> Stage:
    """A stands wholly in T1, its rear 10 m beyond the points."""
    return on_points().see("A", ("T1+", 1.0)).see("A", ("T1+", 50.0), speed_mps=0.0)


def second(stage: Stage) -> Stage:
    """B signs on in the portal E."""
    return stage.put("B", "E-").sign_on("B", "E")


def restarted(*heard: str) -> Stage:
    """The manager has restarted with A and B registered; `heard` are known again."""
    stage = second(authorised())
    stage.restart_manager()
    if "A" in heard:
        stage.accept("A", "W", "P1", "T1")
    if "B" in heard:
        stage.outside("B")
    return stage


Act = Callable[[Stage], Stage]


@dataclass(frozen=True)
class Case:
    """From one situation, what must not be done (`bad`) and what may (`good`)."""

    name: str
    checker: Checker
    start: Callable[[], Stage]
    bad: Act
    good: Act
