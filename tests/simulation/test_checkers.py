"""Each checker against a sequence that breaks exactly it and one that does not; and random lawful running."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import simulation.checkers
from network.model import Position
from simulation.checkers import Checker, Checkers, PointsFacts
from sumo_cfg.truth_map import NetEdge, NetMap

# W | stem1 -< normal1 - T1 - normal2 >- stem2 | B | E, and reverse1 - T2 - reverse2
PIECES = {
    "W": ("W", 300.0),
    "stem1": ("P1", 10.0),
    "normal1": ("P1", 30.0),
    "reverse1": ("P1", 30.0),
    "T1": ("T1", 260.0),
    "T2": ("T2", 260.0),
    "normal2": ("P2", 30.0),
    "reverse2": ("P2", 30.0),
    "stem2": ("P2", 10.0),
    "B": ("B", 500.0),
    "E": ("E", 300.0),
}
JOINTS = (
    ("W", "stem1"),
    ("stem1", "normal1"),
    ("stem1", "reverse1"),
    ("normal1", "T1"),
    ("reverse1", "T2"),
    ("T1", "normal2"),
    ("T2", "reverse2"),
    ("normal2", "stem2"),
    ("reverse2", "stem2"),
    ("stem2", "B"),
    ("B", "E"),
)
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

    def __init__(self) -> None:
        self.checkers = Checkers(net(), POINTS, portals=("W", "E"))
        self.t_s = 0.0
        self.token = 0

    def entry(self, who: str, what: str, **data: object) -> None:
        self.t_s += 1.0
        self.checkers.journal({"t": self.t_s, "who": who, "what": what, **data})

    def manager(self, what: str, unit: str, *sections: str) -> None:
        self.entry("block-manager", what, unit=unit, sections=list(sections))

    def grant(self, unit: str, *sections: str, token: int | None = None) -> None:
        self.token = self.token + 1 if token is None else token
        self.entry(
            "block-manager", "granted", unit=unit, route="r", sections=list(sections), token=self.token
        )

    def holds(self, unit: str, *sections: str) -> None:
        self.entry(unit, "holds", sections=list(sections))

    def see(self, unit: str, *places: tuple[str, float], speed_mps: float = 10.0) -> None:
        for edge, front_m in places:
            self.t_s += 1.0
            self.checkers.observe(self.t_s, unit, edge, front_m, speed_mps)

    def put(self, unit: str, edge: str, front_m: float = 200.0, length_m: float = TRAIN_M) -> None:
        self.checkers.entered(unit, length_m, (edge,))
        self.see(unit, (edge, front_m), speed_mps=0.0)

    def sign_on(self, unit: str, *sections: str) -> None:
        self.manager("signed_on", unit, *sections)
        self.holds(unit, *sections)

    def prove(self, unit: str, points: str, position: str, token: int | None = None) -> None:
        token = self.token if token is None else token
        self.entry(unit, "proven", points=points, position=position, token=token)

    def bounds(self, true_m: float, behind_m: float, ahead_m: float) -> None:
        self.checkers.bounds(self.t_s, "A", true_m, 1000.0, behind_m, ahead_m)

    def effect(self, receiver: str, epoch: int, sequence: int) -> None:
        self.entry(receiver, "took_effect", receiver=receiver, source="S", epoch=epoch, sequence=sequence)

    def broken(self) -> set[str]:
        return {violation.checker for violation in self.checkers.violations}


def authorised() -> Stage:
    """A stands in the portal W and may run to T1, points 1 proven in normal."""
    stage = Stage()
    stage.put("A", "W+")
    stage.sign_on("A", "W")
    stage.grant("A", "P1", "T1")
    stage.holds("A", "W", "P1", "T1")
    stage.prove("A", "1", "normal")
    return stage


def on_points() -> Stage:
    """A has its front on the normal leg and its rear still in W: 10 + 20 of its 40 m are on the points."""
    stage = authorised()
    stage.see("A", ("stem1+", 5.0), ("normal1+", 20.0))
    return stage


def in_track() -> Stage:
    """A stands wholly in T1, its rear 10 m beyond the points."""
    stage = on_points()
    stage.see("A", ("T1+", 1.0))
    stage.see("A", ("T1+", 50.0), speed_mps=0.0)
    return stage


def second(stage: Stage) -> Stage:
    """B signs on in the portal E."""
    stage.put("B", "E-")
    stage.sign_on("B", "E")
    return stage


def restarted(*heard: str) -> Stage:
    """The manager has restarted with A and B registered; `heard` are known again."""
    stage = second(authorised())
    stage.entry("block-manager", "restarted", epoch=2, registered=["A", "B"])
    if "A" in heard:
        stage.manager("claimed", "A", "W", "P1", "T1")
    if "B" in heard:
        stage.manager("outside", "B")
    return stage


Act = Callable[[Stage], object]


@dataclass(frozen=True)
class Case:
    """From one situation, what must not be done (`bad`) and what may (`good`)."""

    name: str
    checker: Checker
    start: Callable[[], Stage]
    bad: Act
    good: Act


def each(*acts: Act) -> Act:
    def run(stage: Stage) -> None:
        for act in acts:
            act(stage)

    return run


def run_in(stage: Stage) -> None:
    stage.see("A", ("stem1+", 5.0), ("normal1+", 20.0), ("T1+", 1.0), ("T1+", 50.0))


CASES = (
    # 40 m back from the front: at normal1 29.5 m the rear is 0.5 m inside W, at T1 0.5 m it is 0.5 m out of it
    Case(
        "rear still in the portal",
        Checker.ONE_TRAIN_A_SECTION,
        authorised,
        lambda s: (s.see("A", ("stem1+", 5.0), ("normal1+", 29.5)), s.put("B", "W+", 100.0)),
        lambda s: (s.see("A", ("stem1+", 5.0), ("normal1+", 29.5), ("T1+", 0.5)), s.put("B", "W+", 100.0)),
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
        lambda s: (s.manager("claimed", "A", "W", "T1"), s.manager("confirmed_by_hand", "B", "E", "T1")),
        lambda s: (s.manager("claimed", "A", "W", "T1"), s.manager("confirmed_by_hand", "B", "E")),
    ),
    Case(
        "freed by the manager under the train",
        Checker.INSIDE_HOLDING,
        in_track,
        lambda s: (s.manager("freed", "A", "T1"), s.see("A", ("T1+", 50.0))),
        lambda s: (s.manager("freed", "A", "W", "P1"), s.see("A", ("T1+", 50.0))),
    ),
    Case(
        "before the unit holds",
        Checker.INSIDE_HOLDING,
        authorised,
        lambda s: (s.holds("A", "W", "P1"), run_in(s)),
        lambda s: (s.holds("A", "W", "P1", "T1"), run_in(s)),
    ),
    Case(
        "never granted",
        Checker.INSIDE_HOLDING,
        lambda: second(Stage()),
        lambda s: (s.holds("B", "E", "B"), s.see("B", ("B-", 5.0))),
        lambda s: (s.grant("B", "B"), s.holds("B", "E", "B"), s.see("B", ("B-", 5.0))),
    ),
    Case(
        "not signed on",
        Checker.INSIDE_HOLDING,
        Stage,
        lambda s: (s.put("B", "E-"), s.holds("B", "E"), s.see("B", ("B-", 5.0))),
        lambda s: (s.put("B", "E-"), s.holds("B", "E"), s.see("B", ("E-", 299.0))),
    ),
    Case(
        "signed off",
        Checker.INSIDE_HOLDING,
        lambda: second(Stage()),
        lambda s: (
            s.grant("B", "B"),
            s.holds("B", "B", "E"),
            s.manager("outside", "B"),
            s.see("B", ("B-", 9.0)),
        ),
        lambda s: (s.manager("outside", "B"), s.holds("B"), s.see("B", ("E-", 290.0)), s.checkers.left("B")),
    ),
    Case(
        "unit restarted",
        Checker.INSIDE_HOLDING,
        authorised,
        lambda s: (
            s.manager("freed", "A", "T1"),
            s.entry("A", "restarted"),
            s.prove("A", "1", "normal"),
            run_in(s),
        ),
        lambda s: (s.entry("A", "restarted"), s.prove("A", "1", "normal"), run_in(s)),
    ),
    Case(
        "wrong position",
        Checker.POINTS_UNDER_TRAIN,
        authorised,
        lambda s: (s.entry("world", "points_locked", points="1", position="reverse"), run_in(s)),
        lambda s: (s.entry("world", "points_locked", points="1", position="normal"), run_in(s)),
    ),
    Case(
        "unlocked under the train",
        Checker.POINTS_UNDER_TRAIN,
        on_points,
        lambda s: s.entry("world", "points_unlocked", points="1"),
        lambda s: s.entry("world", "points_unlocked", points="2"),
    ),
    Case(
        "forced open under the train",
        Checker.POINTS_UNDER_TRAIN,
        on_points,
        lambda s: s.entry("world", "points_lost", points="1"),
        lambda s: s.entry("world", "points_lost", points="2"),
    ),
    Case(
        "still moving when the train comes",
        Checker.POINTS_UNDER_TRAIN,
        authorised,
        lambda s: (s.entry("world", "points_moving", points="1", target="normal"), run_in(s)),
        lambda s: (
            s.entry("world", "points_moving", points="1", target="normal"),
            s.entry("world", "points_locked", points="1", position="normal"),
            run_in(s),
        ),
    ),
    Case(
        "thrown under the rear",
        Checker.NO_THROW_UNDER_TRAIN,
        lambda: each(lambda s: s.see("A", ("T1+", 39.5)))(stage := on_points()) or stage,
        lambda s: s.entry("world", "points_moving", points="1", target="reverse"),
        lambda s: (
            s.see("A", ("T1+", 40.5)),
            s.entry("world", "points_moving", points="1", target="reverse"),
        ),
    ),
    Case(
        "no proof",
        Checker.PROVEN_BEFORE_ENTRY,
        authorised,
        lambda s: (s.entry("A", "proof_dropped", points="1"), s.see("A", ("stem1+", 5.0))),
        lambda s: s.see("A", ("stem1+", 5.0)),
    ),
    Case(
        "proof of the other position",
        Checker.PROVEN_BEFORE_ENTRY,
        authorised,
        lambda s: (s.prove("A", "1", "reverse"), run_in(s)),
        run_in,
    ),
    Case(
        "proof of an earlier grant",
        Checker.PROVEN_BEFORE_ENTRY,
        authorised,
        lambda s: (s.prove("A", "1", "normal", token=0), run_in(s)),
        lambda s: (s.grant("A", "P1", "T1"), run_in(s)),
    ),
    Case(
        "proof outlives the holding",
        Checker.PROVEN_BEFORE_ENTRY,
        authorised,
        lambda s: (s.holds("A", "W"), s.holds("A", "W", "P1", "T1"), run_in(s)),
        lambda s: (s.holds("A", "W", "P1"), s.holds("A", "W", "P1", "T1"), run_in(s)),
    ),
    Case(
        "dropped under the rear",
        Checker.RELEASE_BEHIND_REAR,
        on_points,
        lambda s: s.holds("A", "P1", "T1"),
        lambda s: (s.see("A", ("T1+", 0.5)), s.holds("A", "P1", "T1")),
    ),
    Case(
        "reported without the section under the rear",
        Checker.RELEASE_BEHIND_REAR,
        on_points,
        lambda s: s.entry("A", "reported", sections=["P1", "T1"]),
        lambda s: s.entry("A", "reported", sections=["W", "P1", "T1"]),
    ),
    Case(
        "one unit not heard",
        Checker.UNDEFINED_GRANTS_NOTHING,
        lambda: restarted("A"),
        lambda s: s.grant("A", "P2", "B"),
        lambda s: (s.manager("signed_on", "B", "E"), s.grant("A", "P2", "B")),
    ),
    Case(
        "a unit the manager forgot",
        Checker.UNDEFINED_GRANTS_NOTHING,
        lambda: second(authorised()),
        lambda s: (
            s.entry("block-manager", "restarted", epoch=2, registered=["A"]),
            s.manager("claimed", "A", "W", "P1", "T1"),
            s.grant("A", "P2", "B"),
        ),
        lambda s: (
            s.manager("outside", "B"),
            s.entry("block-manager", "restarted", epoch=2, registered=["A"]),
            s.manager("claimed", "A", "W", "P1", "T1"),
            s.grant("A", "P2", "B"),
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
        lambda: each(lambda s: s.effect("R", 1, 7))(stage := Stage()) or stage,
        lambda s: s.effect("R", 1, 7),
        lambda s: (s.effect("R", 1, 8), s.effect("R", 2, 7), s.effect("Q", 1, 7)),
    ),
    Case(
        "collision",
        Checker.SUMO_COLLISION,
        authorised,
        lambda s: s.entry("world", "collision", text="frontal collision of A with B"),
        lambda s: s.entry("A", "collision", text="not the world's word"),
    ),
    Case(
        "one did not arrive",
        Checker.EVERYONE_ARRIVES,
        Stage,
        lambda s: s.checkers.finish(9.0, {"322M": True, "324M": False}),
        lambda s: s.checkers.finish(9.0, {"322M": True, "324M": True}),
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
        lambda s: (s.checkers.reversed(s.t_s, "B"), s.see("B", ("E+", 140.0))),
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
        lambda s: (s.see("A", ("W+", 210.0)), s.checkers.reversed(s.t_s, "A")),
        lambda s: (s.see("A", ("W+", 210.0), speed_mps=0.0), s.checkers.reversed(s.t_s, "A")),
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
    stage.checkers.reversed(stage.t_s, "A")
    stage.see("A", ("T1+", 20.0), speed_mps=0.0)  # SUMO turns the train in its next step
    stage.see("A", ("normal1-", 20.0), speed_mps=0.0)
    stage.entry("world", "points_moving", points="1", target="reverse")
    assert stage.broken() == {"no-throw-under-train"}


def test_after_a_change_of_ends_the_other_end_clears() -> None:
    """From T1 back to W: T1 is clear when 30 + 10 m of points and then nothing of 40 m is left of it."""
    stage = in_track()
    stage.checkers.reversed(stage.t_s, "A")
    stage.see("A", ("T1-", 250.0), ("normal1-", 5.0), ("stem1-", 5.0), ("W-", 0.5))
    stage.holds("A", "W", "P1")
    assert stage.broken() == set()
    stage.entry("A", "reported", sections=["W"])
    assert stage.broken() == {"release-behind-rear"}


def test_an_unseen_short_edge_is_still_entered() -> None:
    stage = authorised()
    stage.entry("A", "proof_dropped", points="1")
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
    allowed = ("network.model", "simulation.checkers", "sumo_cfg.truth_map")
    files = sorted(Path(simulation.checkers.__file__).parent.glob("checkers*.py"))
    assert files
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            ours = [
                n for n in names if n.split(".")[0] in {"network", "onboard", "wayside", "sumo_cfg", "radio"}
            ]
            assert all(name.startswith(allowed) for name in ours), (file.name, names)


# random lawful running -----------------------------------------------------------------------------------------

DOWN_LEGS = {"T1": ("normal1", "T1", "normal2"), "T2": ("reverse1", "T2", "reverse2")}
USUAL = {"+": "T1", "-": "T2"}


@dataclass
class Runner:
    """A lawful train: where it is on its way from portal to portal, and what it has."""

    sign: str
    track: str
    length_m: float
    front_m: float = 200.0
    held: list[str] = field(default_factory=list)
    proven: dict[str, str] = field(default_factory=dict)

    @property
    def way(self) -> list[tuple[str, float, float]]:
        """Pieces of the way with the distances at which they begin and end."""
        first, track, last = DOWN_LEGS[self.track]
        pieces = ["W", "stem1", first, track, last, "stem2", "B", "E"]
        if self.sign == "-":
            pieces.reverse()
        begin_m, way = 0.0, []
        for piece in pieces:
            way.append((piece, begin_m, begin_m + PIECES[piece][1]))
            begin_m += PIECES[piece][1]
        return way

    def under(self, from_m: float, to_m: float) -> list[str]:
        """Sections between two distances on the way."""
        found = [PIECES[piece][0] for piece, begin_m, end_m in self.way if begin_m < to_m and end_m > from_m]
        return list(dict.fromkeys(found))

    def limit_m(self) -> float:
        """Where what is held and proven ends."""
        limit_m = 0.0
        for piece, begin_m, end_m in self.way:
            section = PIECES[piece][0]
            points = {"P1": "1", "P2": "2"}.get(section)
            if begin_m >= self.front_m and (
                section not in self.held or (points and points not in self.proven)
            ):
                return begin_m
            limit_m = end_m
        return limit_m


class Lawful:
    """Trains A, B, C that keep every rule, driven by random acts; an act that is not allowed now does nothing."""

    def __init__(self) -> None:
        self.stage = Stage()
        self.trains: dict[str, Runner] = {}
        self.register: dict[str, list[str]] = {}
        self.unheard: set[str] = set()
        self.position = {"1": "normal", "2": "normal"}

    def free(self, sections: list[str], unit: str) -> bool:
        taken = {s for other, held in self.register.items() if other != unit for s in held}
        return not self.unheard and not taken & set(sections)

    def enter(self, unit: str, share: float) -> None:
        sign = "+" if share < 0.5 else "-"
        portal = "W" if sign == "+" else "E"
        there = {s for r in self.trains.values() for s in r.under(r.front_m - r.length_m, r.front_m)}
        if unit in self.trains or portal in there or not self.free([portal], unit):
            return
        self.trains[unit] = runner = Runner(sign, USUAL[sign], 20.0 + 180.0 * share, held=[portal])
        self.stage.put(unit, portal + sign, runner.front_m, runner.length_m)
        self.register[unit] = [portal]
        self.stage.sign_on(unit, portal)

    def ask(self, unit: str, share: float) -> None:
        runner = self.trains[unit]
        at = PIECES[next(piece for piece, _, end_m in runner.way if end_m >= runner.front_m)][0]
        if at in ("W", "E"):
            runner.track = "T1" if share < 0.5 else "T2"
        sections = list(dict.fromkeys(PIECES[piece][0] for piece, _, _ in runner.way))
        track = sections.index(runner.track)
        ahead = {sections[0]: sections[1 : track + 1], runner.track: sections[track + 1 :]}.get(at, [])
        if not ahead or set(ahead) <= set(runner.held) or not self.free(ahead, unit):
            return
        self.register[unit] = list(dict.fromkeys([*self.register[unit], *ahead]))
        runner.held = list(dict.fromkeys([*runner.held, *ahead]))
        self.stage.grant(unit, *ahead)
        self.stage.holds(unit, *runner.held)

    def throw(self, unit: str, _share: float) -> None:
        runner = self.trains[unit]
        position = "normal" if runner.track == "T1" else "reverse"
        under = runner.under(runner.front_m - runner.length_m, runner.front_m)
        for points, section in (("1", "P1"), ("2", "P2")):
            if section not in runner.held or section in under or points in runner.proven:
                continue
            if self.position[points] != position:
                self.stage.entry("world", "points_moving", points=points, target=position)
                self.stage.entry("world", "points_locked", points=points, position=position)
                self.position[points] = position
            runner.proven[points] = position
            self.stage.prove(unit, points, position)

    def run(self, unit: str, share: float) -> None:
        runner = self.trains[unit]
        to_m = runner.front_m + share * max(0.0, runner.limit_m() - runner.front_m)
        for piece, begin_m, end_m in runner.way:
            if end_m > runner.front_m and begin_m < to_m:
                middle_m = (max(begin_m, runner.front_m) + min(end_m, to_m)) / 2.0
                for at_m in (middle_m, min(end_m, to_m)):
                    self.stage.see(unit, (piece + runner.sign, at_m - begin_m))
        runner.front_m = max(runner.front_m, to_m)

    def release(self, unit: str, _share: float) -> None:
        runner = self.trains[unit]
        behind = set(runner.under(0.0, runner.front_m)) - set(
            runner.under(runner.front_m - runner.length_m, runner.front_m)
        )
        freed = [section for section in runner.held if section in behind]
        if not freed or unit in self.unheard:
            return
        runner.held = [section for section in runner.held if section not in behind]
        for points, section in (("1", "P1"), ("2", "P2")):
            if section in freed:
                runner.proven.pop(points, None)
        self.stage.holds(unit, *runner.held)
        self.stage.entry(unit, "reported", sections=runner.held)
        self.register[unit] = list(runner.held)
        self.stage.manager("freed", unit, *freed)

    def turn(self, unit: str, share: float) -> None:
        runner = self.trains[unit]
        if runner.under(runner.front_m - runner.length_m, runner.front_m) != [runner.track]:
            return
        begin_m, end_m = next((b, e) for piece, b, e in runner.way if piece == runner.track)
        old = (runner.track + runner.sign, runner.front_m - begin_m)
        self.stage.see(unit, old, speed_mps=0.0)
        self.stage.checkers.reversed(self.stage.t_s, unit)
        if share < 0.5:
            self.stage.see(unit, old, speed_mps=0.0)
        rear_m = runner.front_m - runner.length_m
        runner.sign = "-" if runner.sign == "+" else "+"
        new_begin_m = next(b for piece, b, _ in runner.way if piece == runner.track)
        runner.front_m = new_begin_m + end_m - rear_m
        self.stage.see(unit, (runner.track + runner.sign, end_m - rear_m), speed_mps=0.0)

    def leave(self, unit: str, _share: float) -> None:
        runner = self.trains[unit]
        if runner.held != [PIECES[runner.way[-1][0]][0]] or self.unheard:
            return
        self.register[unit] = []
        self.stage.manager("freed", unit, *runner.held)
        self.stage.manager("outside", unit)
        self.stage.holds(unit)
        self.run(unit, 1.0)
        self.stage.checkers.left(unit)
        del self.trains[unit]

    def restart(self, _unit: str, _share: float) -> None:
        self.unheard = set(self.trains)
        self.stage.entry("block-manager", "restarted", epoch=2, registered=sorted(self.unheard))

    def claim(self, unit: str, _share: float) -> None:
        if unit in self.unheard:
            self.unheard.discard(unit)
            self.stage.manager("claimed", unit, *self.trains[unit].held)


ACTS = ("enter", "ask", "throw", "run", "run", "release", "turn", "leave", "restart", "claim")
acts = st.tuples(st.sampled_from(ACTS), st.sampled_from("ABC"), st.floats(0.0, 1.0))


@settings(max_examples=150, deadline=None)
@given(st.lists(acts, max_size=80))
def test_lawful_running_breaks_nothing(sequence: list[tuple[str, str, float]]) -> None:
    line = Lawful()
    for act, unit, share in sequence:
        if act in ("enter", "restart") or unit in line.trains:
            getattr(line, act)(unit, share)
        assert line.stage.checkers.violations == ()


def test_the_lawful_line_carries_trains_through() -> None:
    """The random test is worth something only if its trains can cross, turn and leave."""
    line = Lawful()
    script = "enter ask throw run release ask throw run release leave"
    for act in script.split():
        getattr(line, act)("A", 0.3 if act in ("enter", "ask") else 1.0)
    assert line.trains == {}
    for act in ("enter", "ask", "throw", "run", "release", "turn"):
        getattr(line, act)("B", 0.6 if act in ("enter", "ask") else 1.0)
    for act in ("ask", "throw", "run", "release", "leave"):
        getattr(line, act)("B", 1.0)
    assert line.trains == {}
    assert line.stage.checkers.violations == ()
