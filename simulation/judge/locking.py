"""Proofs that were lost while the train could no longer stop before the points: route locking (進路鎖錠) has to hold.

A train that has no proof any more may still come onto the points without breaking `proven-before-entry` if

- the proof was lost nearer to them than the train is guaranteed to stop in by its emergency brake, from its true speed;
- from then on it is nowhere faster than that brake lets it be, until it is over them or stands;
- the points stay locked as they were proven, from the loss until it is over them.

What the brake is guaranteed to give is handed in, as is how the track lies; the way is SUMO's. With reaction time r
and deceleration b, a train seen at v that gained a lately does at most v + a r at the end of r, and from there v^2/2
falls by b on each metre and by gravity on each metre climbed. Heights are those under the front: where the gradient
changes under the train, the curve is off by half its length times that change.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from simulation.judge.body import Body, NetTrack
from simulation.judge.points import ProvenPoints

TOLERANCE_MPS: Final = 0.2  # a step of 0.1 s, and what brakes differ within it


@dataclass(frozen=True, slots=True)
class GuaranteedBrake:
    """What the emergency brake of a stock is guaranteed to give, and gravity's part of its inert mass, m/s^2."""

    deceleration_mps2: float
    reaction_s: float
    gravity_mps2: float

    def speed2(self, speed_mps: float, gain_mps2: float, run_m: float, climb_m: float) -> float:
        """Square of the greatest speed `run_m` after the train was seen at `speed_mps`; not positive: it stands."""
        after_mps = speed_mps + max(gain_mps2, 0.0) * self.reaction_s
        reaction_m = (speed_mps + after_mps) / 2.0 * self.reaction_s
        if run_m <= reaction_m:
            return after_mps**2
        loss = self.deceleration_mps2 * (run_m - reaction_m) + self.gravity_mps2 * climb_m
        return after_mps**2 - 2.0 * loss


@dataclass(slots=True)
class _Loss:
    """A proof that a unit lost while its train ran: how fast and where it was then, and what went wrong since."""

    proof: ProvenPoints
    speed_mps: float
    gain_mps2: float
    run_m: float
    height_m: float
    braked: bool = True
    locked: bool = True
    entered: bool = False


class RouteLocking:
    """The losses of all trains; one is over when the train stands, has a proof again, or is off the points."""

    def __init__(self, brakes: Mapping[str, GuaranteedBrake], track: NetTrack) -> None:
        self._brakes = brakes
        self._track = track
        self._losses: dict[str, dict[str, _Loss]] = {}

    def proofs_lost(self, body: Body, proofs: Mapping[str, ProvenPoints]) -> None:
        """The unit has no proofs any more of these points."""
        if body.unit_id in self._brakes and body.speed_mps > 0.0:
            losses = self._losses.setdefault(body.unit_id, {})
            run_m, height_m = body.run_m, self._track.height_m(body)
            for points_id, proof in proofs.items():
                losses[points_id] = _Loss(proof, body.speed_mps, body.acceleration_mps2, run_m, height_m)

    def forget_losses(self, unit_id: str, points_ids: Iterable[str] | None = None) -> None:
        """Losses of these points, or of all, count no more."""
        if points_ids is None:
            self._losses.pop(unit_id, None)
        for points_id in points_ids or ():
            self._losses.get(unit_id, {}).pop(points_id, None)

    def points_stirred(self, points_id: str) -> list[str]:
        """The lock of points opened, or they moved; the units that came onto them by a loss, to which that is new."""
        found: list[str] = []
        for unit_id, losses in self._losses.items():
            loss = losses.get(points_id)
            if loss is not None and loss.locked:
                loss.locked = False
                found += [unit_id] if loss.entered else []
        return found

    def observe(self, body: Body) -> list[str]:
        """The train was seen; the points that it came onto by a loss and over which it does not brake as it must."""
        losses = self._losses.get(body.unit_id)
        if not losses:
            return []
        if body.speed_mps == 0.0:
            self.forget_losses(body.unit_id)
            return []
        found: list[str] = []
        for points_id, loss in losses.items():
            limit2 = self._limit2(body, loss, body.run_m)
            if loss.braked and body.speed_mps > math.sqrt(max(limit2, 0.0)) + TOLERANCE_MPS:
                loss.braked = False
                found += [points_id] if loss.entered else []
        return found

    def enters(self, body: Body, piece_id: str, points_id: str) -> str | ProvenPoints:
        """The front has come onto points without a proof: the one that was lost too late to stop, or what is wrong."""
        loss = self._losses.get(body.unit_id, {}).get(points_id)
        if loss is None:
            return "without a proof"
        now_m = body.run_m
        joint_m = now_m - body.front_m if self._track.piece_of(body.edge_id) == piece_id else now_m
        lost_m = joint_m - loss.run_m
        limit_mps = math.sqrt(max(self._limit2(body, loss, now_m), 0.0))
        loss.braked = loss.braked and body.speed_mps <= limit_mps + TOLERANCE_MPS
        if not loss.entered and self._limit2(body, loss, joint_m) <= 0.0:
            return f"without a proof, lost {lost_m:.0f} m before, of which it is guaranteed to stop in less"
        if not loss.locked:
            return "without a proof, and they did not stay locked since it was lost"
        if not loss.braked:
            return f"without a proof, lost {lost_m:.0f} m before, and did not brake as it is guaranteed to"
        loss.entered = True
        return loss.proof

    def remembered(self, unit_id: str, points_id: str) -> ProvenPoints | None:
        """The proof that the unit lost last of these points."""
        loss = self._losses.get(unit_id, {}).get(points_id)
        return None if loss is None else loss.proof

    def is_clear_of(self, body: Body, points_id: str) -> None:
        """The train is wholly off points that it had come onto."""
        self.forget_losses(body.unit_id, (points_id,))

    def _limit2(self, body: Body, loss: _Loss, at_m: float) -> float:
        """Square of the speed that the guaranteed brake lets the train have at a place on its run."""
        climb_m = self._track.height_m(body) - loss.height_m
        return self._brakes[body.unit_id].speed2(loss.speed_mps, loss.gain_mps2, at_m - loss.run_m, climb_m)
