"""What the judge of level crossings finds and what it passes over."""

from typing import Final

from simulation.events import (
    BarrierState,
    CrossingBarriers,
    CrossingCreep,
    CrossingLamps,
    CrossingOpens,
    RoadStopped,
    TookEffect,
)
from simulation.judge.checkers import Checker
from simulation.judge.crossings import CrossingFacts
from tests.simulation.judge.stage import Case, Stage, at_crossings, authorised, on_points

DARK = CrossingLamps(crossing_id="T", lit=False)
GUARDED = CrossingCreep(crossing_id="W", guarded=True)


def opens(stage: Stage, *struck_off: str) -> Stage:
    """The device of W opens it, striking off whom its persons named: the barriers begin to rise."""
    stage.entry("W", CrossingOpens(struck_off=struck_off))
    return stage.world(CrossingBarriers(crossing_id="W", state=BarrierState.RISING))


def before_a_joint() -> Stage:
    """A runs on points 1 towards a road 10 m beyond them, which is closed."""
    road = CrossingFacts({"T1+": 10.0, "T1-": 244.0}, False, 20.0, 20.0)
    return on_points({"T": road}).shut("T", 0.0, 21.0)


def turned_before_a_road() -> Stage:
    """A has turned in W, and a road begins 4 m ahead of what was its rear."""
    road = CrossingFacts({"W+": 150.0, "W-": 144.0}, False, 20.0, 20.0)
    return authorised(crossings={"W": road}).turn("A")


def on_the_road() -> Stage:
    """A came onto the closed road over W, whose far side its rear passes once its front is at 296 m."""
    return at_crossings().shut("W", 15.0, 20.0).see("A", ("W+", 249.0), ("W+", 255.0), ("W+", 265.0))


def crept() -> Stage:
    """A creeps over W by leave."""
    leave = CrossingCreep(crossing_id="W")
    return at_crossings().entry("A", leave).see("A", ("W+", 255.0), speed_mps=4.0)


def again(stage: Stage) -> Stage:
    """A creeps onto the road over W once more."""
    return stage.put("A", "W+").see("A", ("W+", 245.0), ("W+", 255.0), speed_mps=4.0)


def stopped(stage: Stage) -> Stage:
    """The road over W is stopped for A, who has leave of him that guards it."""
    return stage.world(RoadStopped(crossing_id="W", unit_id="A")).entry("A", GUARDED)


def told(stage: Stage, kind: str) -> Stage:
    """The device of W has heard A."""
    heard = TookEffect(source="A", receiver="W", epoch=1, sequence=int(stage.t_s), kind=kind, correlation=1)
    return stage.entry("W", heard)


CROSSING_CASES: Final = (
    Case(
        "a road with its barriers still coming down",
        Checker.CROSSING_OPEN,
        at_crossings,
        lambda s: s.world(CrossingLamps(crossing_id="W", lit=True)).see("A", ("W+", 255.0)),
        lambda s: s.shut("W", 15.0, 20.0).see("A", ("W+", 255.0)),
    ),
    Case(
        "a road whose barriers have risen again",
        Checker.CROSSING_OPEN,
        at_crossings,
        lambda s: (
            s.shut("W", 15.0, 20.0)
            .world(CrossingBarriers(crossing_id="W", state=BarrierState.RISING))
            .see("A", ("W+", 255.0))
        ),
        lambda s: s.shut("W", 15.0, 20.0).see("A", ("W+", 255.0)),
    ),
    Case(
        "a road that was asked to close only when it was too late to stop",
        Checker.CROSSING_OPEN,
        lambda: at_crossings().see("A", ("W+", 210.0), ("W+", 240.0), speed_mps=25.0),
        lambda s: s.world(CrossingLamps(crossing_id="W", lit=True)).see("A", ("W+", 255.0), speed_mps=25.0),
        lambda s: opens(s.shut("W", 15.0, 20.0), "A").see("A", ("W+", 255.0), speed_mps=25.0),
    ),
    Case(
        "a road that ceased to be closed too late to stop, and it stood before it",
        Checker.CROSSING_OPEN,
        lambda: opens(at_crossings().see("A", ("W+", 240.0), speed_mps=25.0).shut("W", 15.0, 20.0), "A"),
        lambda s: s.see("A", ("W+", 249.0), speed_mps=0.0).see("A", ("W+", 255.0)),
        lambda s: s.see("A", ("W+", 255.0), speed_mps=25.0),
    ),
    Case(
        "a road beyond a joint that ceased to be closed in time to stop, and too late",
        Checker.CROSSING_OPEN,
        before_a_joint,
        lambda s: s.see("A", ("normal1+", 21.0), speed_mps=1.0).world(DARK).see("A", ("T1+", 15.0)),
        lambda s: s.see("A", ("normal1+", 21.0), speed_mps=9.0).world(DARK).see("A", ("T1+", 15.0)),
    ),
    Case(
        "a road that its device opens too late to stop, and one that two persons have freed",
        Checker.CROSSING_OPEN,
        lambda: at_crossings().see("A", ("W+", 240.0), speed_mps=25.0).shut("W", 15.0, 20.0),
        lambda s: opens(s, "B").see("A", ("W+", 255.0), speed_mps=25.0),
        lambda s: opens(s, "A").see("A", ("W+", 255.0), speed_mps=25.0),
    ),
    Case(
        "a road without barriers that its device opens too late to stop, and one whose lamps fail after it",
        Checker.CROSSING_OPEN,
        lambda: before_a_joint().see("A", ("normal1+", 21.0), speed_mps=9.0),
        lambda s: s.entry("T", CrossingOpens()).world(DARK).see("A", ("T1+", 15.0)),
        lambda s: (
            s.entry("T", CrossingOpens()).world(DARK).shut("T", 0.0, 21.0).world(DARK).see("A", ("T1+", 15.0))
        ),
    ),
    Case(
        "a road that opens with the rear yet to clear it",
        Checker.CROSSING_OPEN,
        on_the_road,
        lambda s: s.see("A", ("W+", 295.0)).entry("W", CrossingOpens()),
        lambda s: s.see("A", ("W+", 297.0)).entry("W", CrossingOpens()),
    ),
    Case(
        "a road that opens under who has crept onto it, and is heard",
        Checker.CROSSING_OPEN,
        crept,
        lambda s: (
            told(s, "CrossingRequest").see("A", ("W+", 295.0), speed_mps=4.0).entry("W", CrossingOpens())
        ),
        lambda s: (
            told(s, "CrossingRequest").see("A", ("W+", 297.0), speed_mps=4.0).entry("W", CrossingOpens())
        ),
    ),
    Case(
        "a road that opens under who has crept onto it, and is not heard any more",
        Checker.CROSSING_OPEN,
        lambda: told(crept(), "CrossingRequest"),
        lambda s: s.see("A", ("W+", 295.0), speed_mps=4.0).entry("W", CrossingOpens()),
        lambda s: told(s, "CrossingOver").see("A", ("W+", 295.0), speed_mps=4.0).entry("W", CrossingOpens()),
    ),
    Case(
        "an open road near before who has turned",
        Checker.CROSSING_OPEN,
        turned_before_a_road,
        lambda s: s.see("A", ("W-", 145.0)),
        lambda s: s.shut("W", 0.0, 21.0).see("A", ("W-", 145.0)),
    ),
    Case(
        "a road that opens under who has turned on it",
        Checker.CROSSING_OPEN,
        lambda: on_the_road().see("A", ("W+", 265.0), speed_mps=0.0).turn("A"),
        lambda s: s.see("A", ("W-", 85.0)).entry("W", CrossingOpens()),
        lambda s: s.see("A", ("W-", 92.0)).entry("W", CrossingOpens()),
    ),
    Case(
        "a road without barriers, unlit",
        Checker.CROSSING_OPEN,
        at_crossings,
        lambda s: s.see("B", ("E-", 250.0)),
        lambda s: s.shut("E", 0.0, 21.0).see("B", ("E-", 250.0)),
    ),
    Case(
        "by leave to creep, and faster",
        Checker.CROSSING_OPEN,
        at_crossings,
        lambda s: s.entry("A", CrossingCreep(crossing_id="W")).see("A", ("W+", 255.0), speed_mps=5.0),
        lambda s: s.entry("A", CrossingCreep(crossing_id="W")).see("A", ("W+", 255.0), speed_mps=4.0),
    ),
    Case(
        "by the word of who guards it, its road not stopped",
        Checker.CROSSING_OPEN,
        at_crossings,
        lambda s: s.entry("A", GUARDED).see("A", ("W+", 255.0), speed_mps=4.0),
        lambda s: stopped(s).see("A", ("W+", 255.0), speed_mps=4.0),
    ),
    Case(
        "a second time by leave for once",
        Checker.CROSSING_OPEN,
        crept,
        again,
        lambda s: again(s.entry("A", CrossingCreep(crossing_id="W"))),
    ),
    Case(
        "a second time, its road stopped once",
        Checker.CROSSING_OPEN,
        lambda: again(stopped(at_crossings())),
        lambda s: again(s.entry("A", GUARDED)),
        lambda s: again(stopped(s)),
    ),
    Case(
        "by leave to creep over another",
        Checker.CROSSING_OPEN,
        at_crossings,
        lambda s: s.entry("B", CrossingCreep(crossing_id="W")).see("B", ("E-", 250.0), speed_mps=4.0),
        lambda s: s.entry("B", CrossingCreep(crossing_id="E")).see("B", ("E-", 250.0), speed_mps=4.0),
    ),
    Case(
        "14 s after it was closed",
        Checker.CROSSING_WARNING,
        at_crossings,
        lambda s: s.shut("W", 15.0, 12.0).see("A", ("W+", 255.0)),
        lambda s: s.shut("W", 10.0, 15.0).see("A", ("W+", 255.0)),
    ),
    Case(
        "23 s after its lamps were lit",
        Checker.CROSSING_WARNING,
        at_crossings,
        lambda s: s.shut("W", 5.0, 17.0).see("A", ("W+", 255.0)),
        lambda s: s.shut("W", 10.0, 15.0).see("A", ("W+", 255.0)),
    ),
)
