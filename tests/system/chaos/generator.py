"""Random cases, each from its family and seed alone: one to twelve faults that all heal, and people who put them right.

What trains carry, who goes first and how long people take are drawn too. Staff tell the truth; one person may say
something wrong of a unit, which nobody else says, and two may bar a unit that is in order.

The faults begin within six minutes in which trains move: at a time, or at an event (and a little later) that falls into
them when nothing fails. What fails (power, a link, points, …) is drawn first, each as likely, then one of its kinds
in the table of faults; fields come from its own schema. Each lasting fault is over after at most four minutes, so that
an hour is enough for what it left to be put right.
"""

import math
from pathlib import Path
from typing import Any, Final

from network.model import SectionKind
from onboard.driving.laws.table import LAW_NAMES
from onboard.duty_parameters import ReleaseRule
from scenario.script_file import names_of
from simulation.faults.fault import Fault, Names
from simulation.people import Pause
from simulation.setup import Setup
from tests.system.chaos import by_people, dispatcher
from tests.system.chaos.case import Case
from tests.system.chaos.course import Course, clock_tenths
from tests.system.chaos.draw import Draw
from tests.system.chaos.families import Family, ground_of
from tests.system.chaos.fault_fields import DRAWN, aimed_at, fields_of, target_of
from tests.system.chaos.run_one import undisturbed
from tests.system.chaos.wide import OVERLAP_P, OVERLAPS_M
from wayside.config import OrderRule

Kinds = tuple[type[Fault[Any]], ...]
WINDOW_S: Final = 360.0
FAULTS_MAX: Final = 12
A_MINUTE_S: Final = 60.0
WINDOW_MIN_S: Final = 30.0  # faults that meet show more than faults that follow one another
DURATION_S: Final = (5.0, 240.0)
EVENT_P: Final = 0.6
BEFORE_S: Final = 30  # trains ask for their routes before they move
GIVE_BACK_P: Final = 0.15
BY_HAND_P: Final = 0.2
OTHER_LAW_P: Final = 0.3
CENTRAL_P: Final = 0.3
BY_SECTION_P: Final = 0.4
CARRIES_P: Final = 0.4
CARRIES: Final = (
    ("tags", "gnss"),
    ("tags", "curvature"),
    ("tags", "curvature", "gnss"),
    ("tags", "beacons"),
    ("curvature", "gnss"),
)
DISPATCH_P: Final = 0.3
PEOPLE_P: Final = 0.5
BARRED_P: Final = 0.15
STAFF_S: Final = {
    Pause.POWER: (60.0, 240.0),
    Pause.POINTS: (20.0, 120.0),
    Pause.PICTURE: (15.0, 200.0),
    Pause.SILENT: (60.0, 300.0),
}
WRONG_P: Final = 0.2
WRONG_PERSON: Final = "trackman"
AIR: Final = {"delay_min_s": 0.1, "delay_mean_s": 0.2, "loss_good_p": 0.01}


def case_of(family: Family, seed: int, nets: Path, *, swarm: bool = False) -> Case:
    """The case of a seed; `nets` keeps the nets of drawn lines. A `swarm` leaves half of what could fail out, so that
    the others meet more often, and has a fault a minute at least.
    """
    ground = ground_of(family, seed)
    draw = Draw(seed, (family.value, "swarm") if swarm else (family.value,))
    scenario, course = undisturbed(ground, nets)
    names = aimed_at(names_of(scenario.setup), scenario.setup.line)
    first_s, last_s = course.moving_s[0] - BEFORE_S, course.moving_s[-1]
    length_s = draw.of("length").by_size(WINDOW_MIN_S, WINDOW_S)
    moves_s = draw.of("window").one_of(course.moving_s)  # lies in the window
    from_s = max(first_s, min(moves_s - BEFORE_S, last_s - length_s))
    times = _Times(from_s, min(from_s + length_s, last_s), course)
    least = math.ceil(length_s / A_MINUTE_S) if swarm else 1
    kinds = swarm_kinds(names, draw.of("swarm")) if swarm else DRAWN
    faults = tuple(
        _fault(times, names, draw.of("fault", str(i)), kinds)
        for i in range(draw.of("count").whole(least, FAULTS_MAX))
    )
    head, acts = (
        _head(family, seed, draw.of("head")),
        [
            *_give_back(times, names, draw.of("give back")),
            *_barred(times, names, draw.of("barred")),
            *_wrong(times, scenario.setup, draw.of("wrong")),
        ],
    )
    if family is Family.WIDE:
        setup, desk = scenario.setup, draw.of("desk")
        head |= dispatcher.carried(setup, draw.of("lidar"))
        head |= dispatcher.means(setup, draw.of("means"))
        acts += dispatcher.said(setup, times.drawn(desk.of("time")), desk)
        acts += dispatcher.driven(setup, times.drawn(desk.of("hand", "time")), desk.of("hand"))
        people = draw.of("substitute")
        tables, paces, off = by_people.worked(setup, times.drawn(people.of("time")), people)
        head |= tables
        head["people"] |= paces
        faults += off
    name = f"{'swarm_' if swarm else ''}{family.value}_{seed}"
    return Case(name, ground, head, faults, tuple(acts))


class _Times:
    """When something begins: the window, and the events in it."""

    def __init__(self, from_s: float, to_s: float, course: Course) -> None:
        self.from_s, self.to_s = from_s, to_s
        self.events = tuple(words for t_s, words in course.events if from_s <= t_s <= to_s)
        self.uses = frozenset(name for t_s, name in course.uses if from_s <= t_s <= to_s)

    def drawn(self, draw: Draw) -> dict[str, Any]:
        """The keys `start` and `after_s`."""
        if self.events and draw.chance(EVENT_P):
            return {
                "start": draw.one_of(self.events),
                "after_s": draw.one_of((0.0, draw.between(0.0, 15.0, 1))),
            }
        return {"start": clock_tenths(draw.between(self.from_s, self.to_s, 1))}


def swarm_kinds(names: Names, draw: Draw) -> Kinds:
    """Kinds of half of what could fail."""
    fails = sorted({kind.changes for kind in DRAWN if kind.targets(names)})
    kept = sorted(fails, key=lambda one: draw.of(one).between(0.0, 1.0, 9))[: max(1, len(fails) // 2)]
    return tuple(kind for kind in DRAWN if kind.changes in kept)


def _fault(times: _Times, names: Names, draw: Draw, kinds: Kinds) -> dict[str, Any]:
    return _failure(times.drawn(draw.of("time")), times.uses, names, draw, kinds)


def _failure(
    when: dict[str, Any], uses: frozenset[str], names: Names, draw: Draw, kinds: Kinds
) -> dict[str, Any]:
    fails = draw.of("quantity").one_of(
        # no charger where trains run from a wire
        sorted({kind.changes for kind in kinds if kind.targets(names)})
    )
    kind = draw.of("kind").one_of([kind for kind in kinds if kind.changes == fails])
    table = {"kind": kind.kind, "target": target_of(kind, names, uses, draw.of("target"))} | when
    if not kind.momentary:
        table["duration_s"] = draw.of("duration").by_size(*DURATION_S)
    return table | fields_of(kind, names, draw.of("field"))


def deed(setup: Setup, draw: Draw) -> tuple[str, dict[str, Any]]:
    """What is done at a desk at once: an act of a dispatcher or a crew, or a fault that begins; which of the two."""
    acts = (*dispatcher.said(setup, {}, draw.of("said")), *dispatcher.driven(setup, {}, draw.of("driven")))
    if acts:
        return "act", draw.one_of(acts)
    names = aimed_at(names_of(setup), setup.line)
    return "fault", _failure({}, frozenset(), names, draw.of("fault"), DRAWN)


def _give_back(times: _Times, names: Names, draw: Draw) -> tuple[dict[str, Any], ...]:
    """A crew that sets its route back, which it may at any time."""
    if not draw.chance(GIVE_BACK_P):
        return ()
    hold_s = draw.between(20.0, 120.0, 0)
    return (
        {"kind": "give_back", "target": draw.one_of(names.units), "person": "crew", "hold_s": hold_s}
        | times.drawn(draw),
    )


def _barred(times: _Times, names: Names, draw: Draw) -> tuple[dict[str, Any], ...]:
    """Two persons who bar a unit that is in order, as if its key were stolen; staff unbar it."""
    if not draw.chance(BARRED_P):
        return ()
    said = {"kind": "bar_unit", "target": draw.one_of(names.units)} | times.drawn(draw)
    later_s = said.get("after_s", 0.0) + draw.between(1.0, 20.0, 1)
    return said | {"person": "controller"}, said | {"person": WRONG_PERSON, "after_s": later_s}


def _wrong(times: _Times, setup: Setup, draw: Draw) -> tuple[dict[str, Any], ...]:
    """What one person says wrongly of a unit: that it is outside, or that it holds sections drawn by chance."""
    if not draw.chance(WRONG_P):
        return ()
    sections = setup.line.sections.values()
    portals = [section.id for section in sections if section.kind is SectionKind.PORTAL]
    said = {"target": draw.one_of(sorted(setup.trains)), "person": WRONG_PERSON} | times.drawn(
        draw.of("time")
    )
    if portals and draw.chance(0.5):
        return ({"kind": "confirm_outside", "place": draw.one_of(portals)} | said,)
    return ({"kind": "confirm_holding", "sections": [draw.one_of(sorted(setup.line.sections))]} | said,)


def _head(family: Family, seed: int, draw: Draw) -> dict[str, Any]:
    head: dict[str, Any] = {"seed": seed}
    if family is not Family.HOUR and draw.chance(0.5):
        head["air"] = AIR
    if draw.chance(BY_HAND_P):
        head["operation"] = {"reentry": "by_hand"}
    if draw.of("interlocking").chance(CENTRAL_P):
        relay = {"interlocking": "relay", "staff_reach_s": 120.0} if draw.of("relay").chance(0.5) else {}
        head["operation"] = head.get("operation", {}) | {"interlocking": "central"} | relay
    if draw.of("release").chance(BY_SECTION_P):
        head["operation"] = head.get("operation", {}) | {"release": ReleaseRule.SECTION.value}
    overlap = draw.of("overlap")
    if family is not Family.WIDE and overlap.chance(OVERLAP_P):  # whose grounds have one
        head["patch"] = {"line": {"set": {"line.overlap_m": overlap.one_of(OVERLAPS_M)}}}
    law = draw.of("law")
    if law.chance(OTHER_LAW_P):
        head["driving"] = {"law": law.one_of(LAW_NAMES)}
    if draw.of("carries").chance(CARRIES_P):
        head["sensors"] = {"carries": list(draw.of("carried").one_of(CARRIES))}
    dispatch = draw.of("dispatch")
    if family is not Family.WIDE and dispatch.chance(DISPATCH_P):  # whose dispatchers may do more
        certificate, order = dispatch.chance(0.5), dispatch.one_of([order.value for order in OrderRule])
        head["dispatch"] = {"certificate": certificate, "order": order}
    head["people"] = _people(draw.of("people"), draw.of("staff"))
    return head


def _people(draw: Draw, staff: Draw) -> dict[str, Any]:
    """Quick people and slow ones; staff react, and where all take long, not so long that an hour would not do."""
    drawn = draw.chance(PEOPLE_P)
    times = draw.one_of((0.0, draw.by_size(0.2, 6.0))) if drawn else 1.0
    waits = {pause.value: staff.by_size(*STAFF_S[pause]) / max(1.0, times) for pause in STAFF_S}
    return {"react": True, **waits} | ({"times": times} if drawn else {})
