"""Each checker against a sequence that breaks exactly it and one that does not."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import pytest

import simulation.judge.checkers
from network.model import Position
from simulation.events import (
    MANAGER,
    WORLD,
    Accepted,
    Collision,
    ConfirmedByHand,
    Entry,
    Event,
    Freed,
    Granted,
    Holds,
    Outside,
    PointsForced,
    PointsLocked,
    PointsMoving,
    PointsUnlocked,
    ProofDropped,
    Proven,
    Reported,
    Started,
    TookEffect,
    UnitRestarted,
)
from simulation.judge.checkers import Checker, Checkers, PointsFacts
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

    def __init__(self, unit_ids: tuple[str, ...] = ("A", "B")) -> None:
        self.checkers = Checkers(net(), POINTS, ("W", "E"), unit_ids)
        self.t_s = 0.0
        self.token = 0

    def entry(self, who: str, event: Event) -> Stage:
        self.t_s += 1.0
        self.checkers.journal(Entry(self.t_s, who, event))
        return self

    def world(self, event: Event) -> Stage:
        return self.entry(WORLD, event)

    def accept(self, unit: str, *sections: str) -> Stage:
        return self.entry(MANAGER, Accepted(unit_id=unit, section_ids=sections, token=0, was="unknown"))

    def by_hand(self, unit: str, *sections: str) -> Stage:
        return self.entry(MANAGER, ConfirmedByHand(unit_id=unit, section_ids=sections, token=0, by="Sato"))

    def free(self, unit: str, *sections: str) -> Stage:
        return self.entry(MANAGER, Freed(unit_id=unit, section_ids=sections))

    def outside(self, unit: str) -> Stage:
        return self.entry(MANAGER, Outside(unit_id=unit))

    def restart_manager(self) -> Stage:
        return self.entry(MANAGER, Started(epoch=2))

    def grant(self, unit: str, *sections: str, token: int | None = None) -> Stage:
        self.token = self.token + 1 if token is None else token
        granted = Granted(unit_id=unit, route_id="r", section_ids=sections, token=self.token)
        return self.entry(MANAGER, granted)

    def holds(self, unit: str, *sections: str) -> Stage:
        return self.entry(unit, Holds(section_ids=sections, token=self.token))

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
        return self.entry(unit, Proven(points_id=points, position=Position(position), token=token))

    def bounds(self, true_m: float, behind_m: float, ahead_m: float) -> Stage:
        self.checkers.bounds(self.t_s, "A", true_m, 1000.0, behind_m, ahead_m)
        return self

    def effect(self, receiver: str, epoch: int, sequence: int) -> Stage:
        return self.entry(
            receiver,
            TookEffect(
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
        self.checkers.left(unit)
        return self

    def finish(self, **arrived: bool) -> Stage:
        self.checkers.finish(self.t_s, arrived)
        return self

    def broken(self) -> set[str]:
        return {violation.checker for violation in self.checkers.violations}


def authorised(unit_ids: tuple[str, ...] = ("A", "B")) -> Stage:
    """A stands in the portal W and may run to T1, points 1 proven in normal."""
    stage = Stage(unit_ids).put("A", "W+").sign_on("A", "W").grant("A", "P1", "T1")
    return stage.holds("A", "W", "P1", "T1").prove("A", "1", "normal")


def on_points() -> Stage:
    """A has its front on the normal leg and its rear still in W: 10 + 20 of its 40 m are on the points."""
    return authorised().see("A", ("stem1+", 5.0), ("normal1+", 20.0))


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


CASES = (
    # 40 m back from the front: at normal1 29.5 m the rear is 0.5 m inside W, at T1 0.5 m it is 0.5 m out of it
    Case(
        "rear still in the portal",
        Checker.ONE_TRAIN_A_SECTION,
        authorised,
        lambda s: s.see("A", ("stem1+", 5.0), ("normal1+", 29.5)).put("B", "W+", 100.0),
        lambda s: s.see("A", ("stem1+", 5.0), ("normal1+", 29.5), ("T1+", 0.5)).put("B", "W+", 100.0),
    ),
    Case(
        "section of another",
        Checker.NO_DOUBLE_GRANT,
        lambda: second(authorised()),
        lambda s: s.grant("B", "B", "P2", "T1"),
        lambda s: s.grant("B", "B", "P2", "T2"),
    ),
    Case(
        "claim of another's section",
        Checker.NO_DOUBLE_GRANT,
        restarted,
        lambda s: s.accept("A", "W", "T1").by_hand("B", "E", "T1"),
        lambda s: s.accept("A", "W", "T1").by_hand("B", "E"),
    ),
    Case(
        "freed by the manager under the train",
        Checker.INSIDE_HOLDING,
        in_track,
        lambda s: s.free("A", "T1").finish(),
        lambda s: s.free("A", "W", "P1").finish(),
    ),
    Case(
        "before the unit holds",
        Checker.INSIDE_HOLDING,
        authorised,
        lambda s: s.holds("A", "W", "P1").run_in(),
        lambda s: s.holds("A", "W", "P1", "T1").run_in(),
    ),
    Case(
        "a unit that never says what it holds",
        Checker.INSIDE_HOLDING,
        lambda: Stage().put("A", "W+").accept("A", "W").grant("A", "P1", "T1").prove("A", "1", "normal"),
        lambda s: s.run_in(),
        lambda s: s.holds("A", "W", "P1", "T1").run_in(),
    ),
    Case(
        "never granted",
        Checker.INSIDE_HOLDING,
        lambda: second(Stage()),
        lambda s: s.holds("B", "E", "B").see("B", ("B-", 5.0)),
        lambda s: s.grant("B", "B").holds("B", "E", "B").see("B", ("B-", 5.0)),
    ),
    Case(
        "not signed on",
        Checker.INSIDE_HOLDING,
        Stage,
        lambda s: s.put("B", "E-").holds("B", "E").see("B", ("B-", 5.0)),
        lambda s: s.put("B", "E-").holds("B", "E").see("B", ("E-", 299.0)),
    ),
    Case(
        "signed off",
        Checker.INSIDE_HOLDING,
        lambda: second(Stage()),
        lambda s: s.grant("B", "B").holds("B", "B", "E").outside("B").see("B", ("B-", 9.0)),
        lambda s: s.outside("B").holds("B").see("B", ("E-", 290.0)).leave("B"),
    ),
    Case(
        "unit restarted",
        Checker.INSIDE_HOLDING,
        authorised,
        lambda s: s.free("A", "T1").entry("A", UnitRestarted(epoch=2)).prove("A", "1", "normal").run_in(),
        lambda s: s.entry("A", UnitRestarted(epoch=2)).prove("A", "1", "normal").run_in(),
    ),
    Case(
        "wrong position",
        Checker.POINTS_UNDER_TRAIN,
        authorised,
        lambda s: s.world(PointsLocked(points_id="1", position=Position.REVERSE)).run_in(),
        lambda s: s.world(PointsLocked(points_id="1", position=Position.NORMAL)).run_in(),
    ),
    Case(
        "unlocked under the train",
        Checker.POINTS_UNDER_TRAIN,
        on_points,
        lambda s: s.world(PointsUnlocked(points_id="1")),
        lambda s: s.world(PointsUnlocked(points_id="2")),
    ),
    Case(
        "forced open under the train",
        Checker.POINTS_UNDER_TRAIN,
        on_points,
        lambda s: s.world(PointsForced(points_id="1")),
        lambda s: s.world(PointsForced(points_id="2")),
    ),
    Case(
        "still moving when the train comes",
        Checker.POINTS_UNDER_TRAIN,
        authorised,
        lambda s: s.world(PointsMoving(points_id="1", target=Position.NORMAL)).run_in(),
        lambda s: (
            s.world(PointsMoving(points_id="1", target=Position.NORMAL))
            .world(PointsLocked(points_id="1", position=Position.NORMAL))
            .run_in()
        ),
    ),
    Case(
        "thrown under the rear",
        Checker.NO_THROW_UNDER_TRAIN,
        lambda: on_points().see("A", ("T1+", 39.5)),
        lambda s: s.world(PointsMoving(points_id="1", target=Position.REVERSE)),
        lambda s: s.see("A", ("T1+", 40.5)).world(PointsMoving(points_id="1", target=Position.REVERSE)),
    ),
    Case(
        "no proof",
        Checker.PROVEN_BEFORE_ENTRY,
        authorised,
        lambda s: s.entry("A", ProofDropped(points_id="1")).see("A", ("stem1+", 5.0)),
        lambda s: s.see("A", ("stem1+", 5.0)),
    ),
    Case(
        "proof of the other position",
        Checker.PROVEN_BEFORE_ENTRY,
        authorised,
        lambda s: s.prove("A", "1", "reverse").run_in(),
        Stage.run_in,
    ),
    Case(
        "proof of an earlier grant",
        Checker.PROVEN_BEFORE_ENTRY,
        authorised,
        lambda s: s.prove("A", "1", "normal", token=0).run_in(),
        lambda s: s.grant("A", "P1", "T1").run_in(),
    ),
    Case(
        "proof outlives the holding",
        Checker.PROVEN_BEFORE_ENTRY,
        authorised,
        lambda s: s.holds("A", "W").holds("A", "W", "P1", "T1").run_in(),
        lambda s: s.holds("A", "W", "P1").holds("A", "W", "P1", "T1").run_in(),
    ),
    Case(
        "dropped under the rear",
        Checker.RELEASE_BEHIND_REAR,
        on_points,
        lambda s: s.holds("A", "P1", "T1"),
        lambda s: s.see("A", ("T1+", 0.5)).holds("A", "P1", "T1"),
    ),
    Case(
        "reported without the section under the rear",
        Checker.RELEASE_BEHIND_REAR,
        on_points,
        lambda s: s.entry(
            "A",
            Reported(
                section_ids=(
                    "P1",
                    "T1",
                ),
                token=1,
            ),
        ),
        lambda s: s.entry(
            "A",
            Reported(
                section_ids=(
                    "W",
                    "P1",
                    "T1",
                ),
                token=1,
            ),
        ),
    ),
    Case(
        "one unit not heard",
        Checker.UNDEFINED_GRANTS_NOTHING,
        lambda: restarted("A"),
        lambda s: s.grant("A", "P2", "B"),
        lambda s: s.accept("B", "E").grant("A", "P2", "B"),
    ),
    Case(
        "a unit on the line that is on no list",
        Checker.UNDEFINED_GRANTS_NOTHING,
        lambda: second(authorised(("A",))),
        lambda s: s.restart_manager().accept("A", "W", "P1", "T1").grant("A", "P2", "B"),
        lambda s: s.outside("B").restart_manager().accept("A", "W", "P1", "T1").grant("A", "P2", "B"),
    ),
    Case(
        "ahead of the bound",
        Checker.WITHIN_BOUNDS,
        Stage,
        lambda s: s.bounds(1002.1, 5.0, 2.0),
        lambda s: s.bounds(1002.0, 5.0, 2.0),
    ),
    Case(
        "behind the bound",
        Checker.WITHIN_BOUNDS,
        Stage,
        lambda s: s.bounds(994.9, 5.0, 2.0),
        lambda s: s.bounds(995.0, 5.0, 2.0),
    ),
    Case(
        "no bound at all",
        Checker.WITHIN_BOUNDS,
        Stage,
        lambda s: s.bounds(1000.0, math.nan, 2.0),
        lambda s: s.bounds(1000.0, math.inf, math.inf),
    ),
    Case(
        "repeated telegram",
        Checker.TELEGRAM_ONCE,
        lambda: Stage().effect("R", 1, 7),
        lambda s: s.effect("R", 1, 7),
        lambda s: s.effect("R", 1, 8).effect("R", 2, 7).effect("Q", 1, 7),
    ),
    Case(
        "collision",
        Checker.SUMO_COLLISION,
        authorised,
        lambda s: s.entry(WORLD, Collision(text="frontal collision of A with B")),
        lambda s: s.entry("A", Collision(text="not the world's word")),
    ),
    Case(
        "one did not arrive",
        Checker.EVERYONE_ARRIVES,
        Stage,
        lambda s: s.finish(first=True, second=False),
        lambda s: s.finish(first=True, second=True),
    ),
    Case(
        "same token again",
        Checker.TOKENS_GROW,
        lambda: second(authorised()),
        lambda s: s.grant("B", "B", "P2", token=1),
        lambda s: s.grant("B", "B", "P2", token=2),
    ),
    Case(
        "to an edge that does not follow",
        Checker.NO_JUMP,
        lambda: second(Stage()),
        lambda s: s.see("B", ("E+", 100.0)),
        lambda s: s.turn("B").see("B", ("E+", 140.0)),
    ),
    Case(
        "backwards",
        Checker.NO_JUMP,
        lambda: second(Stage()),
        lambda s: s.see("B", ("E-", 199.0)),
        lambda s: s.see("B", ("E-", 201.0)),
    ),
    Case(
        "off the net",
        Checker.NO_JUMP,
        lambda: second(Stage()),
        lambda s: s.see("B", ("", 0.0)),
        lambda s: s.see("B", ("E-", 200.0)),
    ),
    Case(
        "changes ends in motion",
        Checker.NO_JUMP,
        authorised,
        lambda s: s.see("A", ("W+", 210.0)).turn("A"),
        lambda s: s.see("A", ("W+", 210.0), speed_mps=0.0).turn("A"),
    ),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.checker}: {case.name}")
def test_each_checker_finds_its_breach_and_nothing_else(case: Case) -> None:
    stage = case.start()
    assert stage.broken() == set()
    case.good(stage)
    assert stage.broken() == set()
    stage = case.start()
    case.bad(stage)
    assert stage.broken() == {case.checker.value}
    assert stage.checkers.counts[case.checker.value] >= 1


def test_every_checker_has_a_case() -> None:
    assert {case.checker for case in CASES} == set(Checker)


def test_a_lasting_breach_is_one_violation_with_its_first_time() -> None:
    stage = Stage()
    for _ in range(3):
        stage.t_s += 1.0
        stage.bounds(1010.0, 5.0, 2.0)
    (violation,) = stage.checkers.violations
    assert violation.t_s == 1.0
    assert "+10.000 m" in violation.text
    assert stage.checkers.counts == {"within-bounds": 3}


def test_change_ends_astride_a_joint() -> None:
    """20 m in T1 and 20 m on the leg: the new front is 20 m into the leg, seen from T1."""
    stage = on_points()
    stage.see("A", ("T1+", 20.0), speed_mps=0.0)
    stage.turn("A")
    stage.see("A", ("T1+", 20.0), speed_mps=0.0)  # SUMO turns the train in its next step
    stage.see("A", ("normal1-", 20.0), speed_mps=0.0)
    stage.world(PointsMoving(points_id="1", target=Position.REVERSE))
    assert stage.broken() == {"no-throw-under-train"}


def test_after_a_change_of_ends_the_other_end_clears() -> None:
    """From T1 back to W: T1 is clear when 30 + 10 m of points and then nothing of 40 m is left of it."""
    stage = in_track()
    stage.turn("A")
    stage.prove("A", "1", "normal")
    stage.see("A", ("T1-", 250.0), ("normal1-", 5.0), ("stem1-", 5.0), ("W-", 0.5))
    stage.holds("A", "W", "P1")
    assert stage.broken() == set()
    stage.entry("A", Reported(section_ids=("W",), token=1))
    assert stage.broken() == {"release-behind-rear"}


def test_an_unseen_short_edge_is_still_entered() -> None:
    stage = authorised()
    stage.entry("A", ProofDropped(points_id="1"))
    stage.see("A", ("normal1+", 5.0))
    assert stage.broken() == {"proven-before-entry"}


def test_rear_outside_the_net_and_touching_a_joint() -> None:
    """A train longer than what it has run is only where the net is; a front on the joint is not beyond it."""
    stage = Stage()
    stage.put("A", "W+", front_m=20.0, length_m=100.0)
    stage.see("A", ("W+", 300.0), ("stem1+", 0.0))
    assert stage.broken() == set()
    stage.see("A", ("stem1+", 0.1))
    assert stage.broken() == {"inside-holding", "proven-before-entry"}


def test_a_train_enters_on_edges_of_the_net() -> None:
    stage = Stage()
    with pytest.raises(ValueError, match="no edge"):
        stage.checkers.entered("A", TRAIN_M, ())
    with pytest.raises(KeyError):
        stage.checkers.entered("A", TRAIN_M, ("nowhere+",))


def test_checkers_share_nothing_with_what_they_check() -> None:
    allowed = ("network.model", "simulation.judge.checkers", "sumo_cfg.truth_map")
    files = sorted(Path(simulation.judge.checkers.__file__).parent.glob("*.py"))
    assert files
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            ours = [
                n for n in names if n.split(".")[0] in {"network", "onboard", "wayside", "sumo_cfg", "radio"}
            ]
            assert all(name.startswith(allowed) for name in ours), (file.name, names)
