"""Each checker against a sequence that breaks exactly it and one that does not."""

import math

import pytest

from network.model import Position
from simulation.events import (
    MANAGER,
    WORLD,
    Collision,
    CutOut,
    PointsForced,
    PointsLocked,
    PointsMoving,
    PointsUnlocked,
    ProofDropped,
    Reported,
    Started,
    TakenBack,
    UnitRestarted,
)
from simulation.judge.checkers import Checker
from simulation.judge.liveness import LOOKS_EVERY_S, STANDS_S
from tests.simulation.judge.crossing_cases import CROSSING_CASES
from tests.simulation.judge.stage import Case, Stage, authorised, in_track, on_points, restarted, second


def let_in_to_t2(stage: Stage) -> Stage:
    """B may run from E to T2, points 2 proven in reverse."""
    return stage.grant("B", "B", "P2", "T2").holds("B", "E", "B", "P2", "T2").prove("B", "2", "reverse")


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
        "claim of what one has that was barred when the line was restored already",
        Checker.NO_DOUBLE_GRANT,
        restarted,
        lambda s: s.accept("A", "W", "T1").defined().bar("A").by_hand("B", "E", "T1"),
        lambda s: s.accept("A", "W", "T1").bar("A").by_hand("B", "E", "T1"),
    ),
    Case(
        "claim of what one has who was accepted after it",
        Checker.NO_DOUBLE_GRANT,
        restarted,
        lambda s: s.accept("B", "E", "T1").by_hand("A", "W", "T1"),
        lambda s: s.accept("B", "E", "T1").by_hand("A", "W"),
    ),
    Case(
        "freed under a train that stands, and its own again a second later",
        Checker.INSIDE_HOLDING,
        in_track,
        lambda s: s.free("A", "T1").accept("A", "T1").finish(),
        lambda s: s.free("A", "P1").accept("A", "T1").finish(),
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
        lambda s: s.free("B", "E").outside("B").finish(),
        lambda s: s.see("B", ("E-", 290.0)).leave("B").holds("B").free("B", "E").outside("B").finish(),
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
        "proof of an earlier grant, which was accepted since",
        Checker.PROVEN_BEFORE_ENTRY,
        lambda: authorised().accept("A", "W", "P1", "T1"),
        lambda s: s.prove("A", "1", "normal", token=0).run_in(),
        Stage.run_in,
    ),
    Case(
        "proof of the train's last stay on the line",
        Checker.PROVEN_BEFORE_ENTRY,
        lambda: authorised().leave("A").outside("A").put("A", "W+").sign_on("A", "W", "P1", "T1"),
        Stage.run_in,
        lambda s: s.prove("A", "1", "normal").run_in(),
    ),
    Case(
        "proof of the way there, on the way back",
        Checker.PROVEN_BEFORE_ENTRY,
        lambda: in_track().turn("A"),
        lambda s: s.see("A", ("T1-", 270.0), ("normal1-", 5.0)),
        lambda s: s.prove("A", "1", "normal").see("A", ("T1-", 270.0), ("normal1-", 5.0)),
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
        lambda s: s.entry("A", Reported(section_ids=("P1", "T1"), token=1)),
        lambda s: s.entry("A", Reported(section_ids=("W", "P1", "T1"), token=1)),
    ),
    Case(
        "one unit not heard",
        Checker.UNDEFINED_GRANTS_NOTHING,
        lambda: restarted("A"),
        lambda s: s.grant("A", "P2", "B"),
        lambda s: s.accept("B", "E").grant("A", "P2", "B"),
    ),
    Case(
        "barred before the line is restored, it is not heard any more",
        Checker.UNDEFINED_GRANTS_NOTHING,
        lambda: restarted("A"),
        lambda s: s.accept("B", "E").bar("B").grant("A", "P2", "B"),
        lambda s: s.accept("B", "E").defined().bar("B").grant("A", "P2", "B"),
    ),
    Case(
        "barred on a line that was never restored, it changes nothing",
        Checker.UNDEFINED_GRANTS_NOTHING,
        lambda: second(authorised()).entry(MANAGER, Started(epoch=1)).accept("A", "W", "P1", "T1"),
        lambda s: s.bar("B").grant("A", "P2", "B"),
        lambda s: s.accept("B", "E").bar("B").grant("A", "P2", "B"),
    ),
    Case(
        "persons take back what they had said of a unit",
        Checker.UNDEFINED_GRANTS_NOTHING,
        lambda: second(authorised()).by_hand("B", "E").entry(MANAGER, TakenBack(unit_id="B", by="Sato")),
        lambda s: s.grant("A", "P2", "B"),
        lambda s: s.accept("B", "E").grant("A", "P2", "B"),
    ),
    Case(
        "a unit on the line that is on no list",
        Checker.UNDEFINED_GRANTS_NOTHING,
        lambda: second(authorised(("A",))),
        lambda s: s.restart_manager().accept("A", "W", "P1", "T1").grant("A", "P2", "B"),
        lambda s: (
            s.leave("B").outside("B").restart_manager().accept("A", "W", "P1", "T1").grant("A", "P2", "B")
        ),
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
        "nothing to come",
        Checker.NO_DEAD_STATE,
        authorised,
        lambda s: s.stand(STANDS_S + LOOKS_EVERY_S, timer=False),
        lambda s: s.stand(STANDS_S + LOOKS_EVERY_S, timer=True).stand(STANDS_S / 2.0, timer=False),
    ),
    Case(
        "same token again",
        Checker.TOKENS_GROW,
        lambda: second(authorised()),
        lambda s: s.grant("B", "B", "P2", token=1),
        lambda s: s.grant("B", "B", "P2", token=2),
    ),
    Case(
        "B onto points 2 while A comes in",
        Checker.ONE_COMES_IN,
        lambda: let_in_to_t2(second(on_points().see("A", ("T1+", 50.0)))),
        lambda s: s.see("B", ("B-", 400.0), ("stem2-", 5.0)),
        lambda s: s.see("A", ("T1+", 60.0), speed_mps=0.0).see("B", ("B-", 400.0), ("stem2-", 5.0)),
    ),
    Case(
        "cut out, into a section between stations without the pilot",
        Checker.PILOTS_LEAVE,
        lambda: on_points().world(CutOut(unit_id="A")),
        lambda s: s.see("A", ("T1+", 50.0), ("normal2+", 5.0), ("stem2+", 5.0), ("B+", 5.0)),
        lambda s: s.see("A", ("T1+", 50.0)),
    ),
    Case(
        "through a limit with its rear",
        Checker.TOO_FAST,
        lambda: let_in_to_t2(second(authorised())).see("B", ("E-", 269.0), speed_mps=25.0),
        lambda s: s.see("B", ("B-", 19.0), speed_mps=18.1),
        lambda s: s.see("B", ("B-", 19.0), speed_mps=17.9).see("B", ("B-", 20.0), speed_mps=25.0),
    ),
    Case(
        "beyond its own greatest speed",
        Checker.TOO_FAST,
        authorised,
        lambda s: s.see("A", ("W+", 240.0), speed_mps=28.1),
        lambda s: s.see("A", ("W+", 240.0), speed_mps=27.9),
    ),
    *CROSSING_CASES,
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
        "nowhere that a number says",
        Checker.NO_JUMP,
        lambda: second(Stage()),
        lambda s: s.see("B", ("E-", math.nan)),
        lambda s: s.see("B", ("E-", 201.0)),
    ),
    Case(
        "at no speed that a number says",
        Checker.NO_JUMP,
        lambda: second(Stage()),
        lambda s: s.see("B", ("E-", 201.0), speed_mps=math.nan),
        lambda s: s.see("B", ("E-", 201.0)),
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
