"""Points (転てつ機) and the trains on them: position and lock as they are, proofs as the units have them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from network.model import Position
from simulation.judge.body import Body
from simulation.judge.log import Checker, Log


@dataclass(frozen=True, slots=True)
class PointsFacts:
    """Pieces of one set of points, the section they lie in, and the position they are first locked in."""

    section_id: str
    stem_piece: str
    normal_piece: str
    reverse_piece: str
    initial: Position


@dataclass(frozen=True, slots=True)
class ProvenPoints:
    """What a unit takes as proven, and under which token."""

    position: Position
    token: int


@dataclass(slots=True)
class _WatchedMachine:
    """Physical state; `position` is None while neither end is reached."""

    position: Position | None
    locked: bool


class PointsWatch:
    """Checks `points-under-train`, `no-throw-under-train` and `proven-before-entry`.

    A leg needs its own position. The stem needs any locked position: which one is right shows on the leg.
    """

    def __init__(self, points: Mapping[str, PointsFacts], log: Log) -> None:
        self._log = log
        self._machines = {
            points_id: _WatchedMachine(facts.initial, True) for points_id, facts in points.items()
        }
        self._sections = {points_id: facts.section_id for points_id, facts in points.items()}
        self._needs: dict[str, tuple[str, Position | None]] = {}
        for points_id, facts in points.items():
            self._needs[facts.stem_piece] = (points_id, None)
            self._needs[facts.normal_piece] = (points_id, Position.NORMAL)
            self._needs[facts.reverse_piece] = (points_id, Position.REVERSE)

    @property
    def ids(self) -> tuple[str, ...]:
        """All points."""
        return tuple(self._machines)

    def section_of(self, points_id: str) -> str:
        """Section of a set of points; KeyError for unknown ones."""
        return self._sections[points_id]

    def needs(self, piece_id: str) -> tuple[str, Position | None] | None:
        """Points that a piece belongs to and the position that leads over it (None on the stem: either)."""
        return self._needs.get(piece_id)

    def moving(self, t_s: float, points_id: str, bodies: Iterable[Body]) -> None:
        """The blades leave their position."""
        for body in self._standing_on(points_id, bodies):
            text = f"points {points_id} thrown under {body.unit_id} at {body.speed_mps:.1f} m/s"
            subject, outside = f"{points_id} {body.unit_id}", self._sections[points_id] in body.overrun
            self._log.note(t_s, Checker.NO_THROW_UNDER_TRAIN, subject, text, outside=outside)
        self._set(points_id, None, False)

    def locked(self, t_s: float, points_id: str, position: Position, bodies: Iterable[Body]) -> None:
        """The points are locked in a position."""
        self._set(points_id, position, True)
        self._check_all(t_s, points_id, bodies)

    def unlocked(self, t_s: float, points_id: str, bodies: Iterable[Body]) -> None:
        """The lock opens; the blades stay where they are."""
        self._machines[points_id].locked = False
        self._check_all(t_s, points_id, bodies)

    def points_lost(self, t_s: float, points_id: str, bodies: Iterable[Body]) -> None:
        """The points are in no position and not locked: forced open, or broken."""
        self._set(points_id, None, False)
        self._check_all(t_s, points_id, bodies)

    def check(self, t_s: float, body: Body) -> None:
        """All points under a train."""
        for piece_id in body.pieces:
            need = self._needs.get(piece_id)
            if need is None:
                continue
            points_id, position = need
            machine = self._machines[points_id]
            if not machine.locked or (position is not None and machine.position is not position):
                lock = "locked" if machine.locked else "not locked"
                at = "no position" if machine.position is None else machine.position.value
                text = f"{body.unit_id} is on {piece_id} while points {points_id} are {lock} in {at}"
                subject, outside = f"{points_id} {body.unit_id}", self._sections[points_id] in body.overrun
                self._log.note(t_s, Checker.POINTS_UNDER_TRAIN, subject, text, outside=outside)

    def check_entry(
        self, t_s: float, unit_id: str, piece_id: str, proof: ProvenPoints | str, token: int, *, outside: bool
    ) -> bool:
        """The front of a train came onto a piece of points: by a proof, or in words by none; whether that is a breach.

        `token` is that of the grant of their section; `outside` the design, see `judge.rail`.
        """
        need = self._needs[piece_id]
        points_id, position = need
        if isinstance(proof, str):
            why = proof
        elif proof.token < token:
            why = f"with the proof of token {proof.token}, older than its grant {token}"
        elif position is not None and proof.position is not position:
            why = f"with a proof for {proof.position.value}"
        else:
            return False
        text = f"{unit_id} came onto {piece_id} of points {points_id} {why}"
        self._log.note(t_s, Checker.PROVEN_BEFORE_ENTRY, f"{points_id} {unit_id}", text, outside=outside)
        return True

    def lock_failed(self, t_s: float, unit_id: str, points_id: str, why: str, *, outside: bool) -> None:
        """Something fails under a train that came onto points without a proof, which it had lost too late to stop."""
        text = (
            f"{unit_id} came onto points {points_id} without a proof, lost too late to stop, and then {why}"
        )
        self._log.note(t_s, Checker.PROVEN_BEFORE_ENTRY, f"{points_id} {unit_id}", text, outside=outside)

    def points_under(self, body: Body) -> set[str]:
        """The points that a train is on."""
        return {need[0] for piece in body.pieces if (need := self._needs.get(piece)) is not None}

    def _set(self, points_id: str, position: Position | None, locked: bool) -> None:
        machine = self._machines[points_id]
        machine.position, machine.locked = position, locked

    def _standing_on(self, points_id: str, bodies: Iterable[Body]) -> list[Body]:
        return [body for body in bodies if points_id in self.points_under(body)]

    def _check_all(self, t_s: float, points_id: str, bodies: Iterable[Body]) -> None:
        for body in self._standing_on(points_id, bodies):
            self.check(t_s, body)
