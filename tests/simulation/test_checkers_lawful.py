"""Trains that keep every rule, driven at random: no checker may find anything."""

from dataclasses import dataclass, field

from hypothesis import given
from hypothesis import strategies as st

from network.model import Position
from simulation import events
from simulation.judge.checkers import Checkers
from tests.simulation.judge.stage import PIECES, POINTS, net

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
    proven: dict[str, Position] = field(default_factory=dict)

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
        self.checkers = Checkers(net(), POINTS, ("A", "B", "C"), {}, {}, 0.8, {})
        self.t_s = 0.0
        self.token = 0
        self.trains: dict[str, Runner] = {}
        self.register: dict[str, list[str]] = {}
        self.unheard: set[str] = set()
        self.position = {"1": Position.NORMAL, "2": Position.NORMAL}

    def entry(self, who: str, event: events.Event) -> None:
        self.t_s += 1.0
        self.checkers.journal(events.JournalEntry(self.t_s, who, event))

    def accept(self, unit: str, sections: list[str]) -> None:
        accepted = events.Accepted(unit_id=unit, section_ids=tuple(sections), token=self.token, was="unknown")
        self.entry(events.MANAGER, accepted)

    def holds(self, unit: str) -> None:
        self.entry(unit, events.Holds(section_ids=tuple(self.trains[unit].held), token=self.token))

    def see(self, unit: str, edge: str, front_m: float, speed_mps: float) -> None:
        self.t_s += 1.0
        self.checkers.observe(self.t_s, unit, edge, front_m, speed_mps)

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
        self.checkers.entered(unit, runner.length_m, (portal + sign,))
        self.see(unit, portal + sign, runner.front_m, 0.0)
        self.register[unit] = [portal]
        self.accept(unit, [portal])
        self.holds(unit)

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
        self.token += 1
        granted = events.Granted(unit_id=unit, route_id="r", section_ids=tuple(ahead), token=self.token)
        self.entry(events.MANAGER, granted)
        self.holds(unit)

    def throw(self, unit: str, _share: float) -> None:
        runner = self.trains[unit]
        position = Position.NORMAL if runner.track == "T1" else Position.REVERSE
        under = runner.under(runner.front_m - runner.length_m, runner.front_m)
        for points, section in (("1", "P1"), ("2", "P2")):
            if section not in runner.held or section in under or points in runner.proven:
                continue
            if self.position[points] != position:
                self.entry(events.WORLD, events.PointsMoving(points_id=points, target=position))
                self.entry(events.WORLD, events.PointsLocked(points_id=points, position=position))
                self.position[points] = position
            runner.proven[points] = position
            self.entry(unit, events.Proven(points_id=points, position=position, token=self.token))

    def run(self, unit: str, share: float) -> None:
        runner = self.trains[unit]
        to_m = runner.front_m + share * max(0.0, runner.limit_m() - runner.front_m)
        for piece, begin_m, end_m in runner.way:
            if end_m > runner.front_m and begin_m < to_m:
                middle_m = (max(begin_m, runner.front_m) + min(end_m, to_m)) / 2.0
                for at_m in (middle_m, min(end_m, to_m)):
                    self.see(unit, piece + runner.sign, at_m - begin_m, 10.0)
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
        self.holds(unit)
        self.entry(unit, events.Reported(section_ids=tuple(runner.held), token=self.token))
        self.register[unit] = list(runner.held)
        self.entry(events.MANAGER, events.Freed(unit_id=unit, section_ids=tuple(freed)))

    def go(self, unit: str, share: float) -> None:
        """As far as it comes: the longest of lawful moves, so that random acts get somewhere."""
        for other in self.trains:
            self.claim(other, share)
        self.ask(unit, share)
        self.throw(unit, share)
        self.run(unit, 1.0)
        self.release(unit, share)

    def turn(self, unit: str, share: float) -> None:
        runner = self.trains[unit]
        if runner.under(runner.front_m - runner.length_m, runner.front_m) != [runner.track]:
            return
        begin_m, end_m = next((b, e) for piece, b, e in runner.way if piece == runner.track)
        old = (runner.track + runner.sign, runner.front_m - begin_m)
        self.see(unit, *old, 0.0)
        self.checkers.reversed(self.t_s, unit)
        if share < 0.5:
            self.see(unit, *old, 0.0)
        runner.proven.clear()
        rear_m = runner.front_m - runner.length_m
        runner.sign = "-" if runner.sign == "+" else "+"
        new_begin_m = next(b for piece, b, _ in runner.way if piece == runner.track)
        runner.front_m = new_begin_m + end_m - rear_m
        self.see(unit, runner.track + runner.sign, end_m - rear_m, 0.0)

    def leave(self, unit: str, _share: float) -> None:
        runner = self.trains[unit]
        if runner.held != [PIECES[runner.way[-1][0]][0]] or self.unheard:
            return
        self.run(unit, 1.0)
        self.checkers.train_left(unit)
        self.register[unit] = []
        self.entry(events.MANAGER, events.Freed(unit_id=unit, section_ids=tuple(runner.held)))
        self.t_s -= 1.0  # the manager writes both in one moment
        self.entry(events.MANAGER, events.Outside(unit_id=unit))
        runner.held = []
        self.holds(unit)
        del self.trains[unit]

    def restart(self, _unit: str, _share: float) -> None:
        self.unheard = set(self.trains)
        self.entry(events.MANAGER, events.Started(epoch=2))
        for unit in sorted({"A", "B", "C"} - self.unheard):
            self.entry(events.MANAGER, events.Outside(unit_id=unit))

    def claim(self, unit: str, _share: float) -> None:
        if unit in self.unheard:
            self.unheard.discard(unit)
            self.accept(unit, self.trains[unit].held)


ACTS = (
    "enter",
    "go",
    "go",
    "go",
    "go",
    "ask",
    "throw",
    "run",
    "release",
    "turn",
    "leave",
    "restart",
    "claim",
)
acts = st.tuples(st.sampled_from(ACTS), st.sampled_from("ABC"), st.floats(0.0, 1.0))


@given(st.lists(acts, max_size=80))
def test_lawful_running_breaks_nothing(sequence: list[tuple[str, str, float]]) -> None:
    line = Lawful()
    for act, unit, share in sequence:
        if act in ("enter", "restart") or unit in line.trains:
            getattr(line, act)(unit, share)
        assert line.checkers.violations == ()


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
    assert line.checkers.violations == ()
