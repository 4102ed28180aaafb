"""The independent checkers: they see the truth and the journal, and share nothing with what they check.

`observe` is SUMO's truth, `journal` what the parties did, `alive` what units show; the one estimate let in is what
`bounds` is told, to be held against the truth. Call `observe` for every train before the journal entries of the same
moment: a release is judged by where the rear is then. The rules are those of `Checker`, each told where it is checked.

A train may occupy a section if the block manager gave it to its unit and the unit counts it as held, a portal too
until the train is off the line. One exception, over for a section once the train has left it: where a train is put on
the line, until the manager has it there and its unit says what it holds. A unit that has restarted knows nothing:
until it says anew what it holds, the manager's word alone counts.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from types import MappingProxyType

from simulation import events
from simulation.judge.body import RESOLUTION_M, Body, Heights, NetTrack
from simulation.judge.crossings import CrossingFacts, CrossingWatch
from simulation.judge.entering import EntryWatch, TrackOverlap
from simulation.judge.liveness import LivenessWatch, TrainAndDisplay
from simulation.judge.locking import GuaranteedBrake, RouteLocking
from simulation.judge.log import Checker, Log, Violation
from simulation.judge.pilot import PilotWatch
from simulation.judge.points import PointsFacts, PointsWatch, ProvenPoints
from simulation.judge.rail import LowAdhesion, RailWatch
from simulation.judge.register import RegisterWatch
from simulation.judge.speed import NO_LIMITS, NOT_RUN, RunSince, SpeedWatch, TrueLimits
from simulation.procedure import WorkingStep
from sumo_cfg.truth_map import NetMap

__all__ = ["Checker", "Checkers", "GuaranteedBrake", "PointsFacts", "Violation"]


class Checkers:
    """All checkers of one run. Every method but `violations` and `counts` only takes in what happened."""

    def __init__(
        self,
        net: NetMap,
        points: Mapping[str, PointsFacts],
        unit_ids: Collection[str],
        brakes: Mapping[str, GuaranteedBrake],
        heights: Heights,
        design_share: float,
        overlaps: Mapping[str, TrackOverlap],
        pilots_needs: Mapping[str, Sequence[WorkingStep]] = MappingProxyType({}),
        crossings: Mapping[str, CrossingFacts] = MappingProxyType({}),
        creep_mps: float = 0.0,
        limits: TrueLimits = NO_LIMITS,
    ) -> None:
        self._log = Log()
        self._track = NetTrack(net, heights)
        self._rail = RailWatch(design_share, brakes)
        self._locking = RouteLocking(brakes, self._track)
        self._points = PointsWatch(points, self._log)
        self._register = RegisterWatch(self._log)
        self._liveness = LivenessWatch(self._log)
        self._entries = EntryWatch(net, overlaps, {facts.section_id for facts in points.values()}, self._log)
        self._pilots = PilotWatch(pilots_needs, self._log)
        self._crossings = CrossingWatch(net, crossings, creep_mps, brakes, self._log)
        self._speed = SpeedWatch(net, limits, self._log)
        self._unit_ids = tuple(unit_ids)  # registered on the line, whatever the manager says of them
        self._bodies: dict[str, Body] = {}
        self._occupants: dict[str, set[str]] = {}
        self._own: dict[str, frozenset[str]] = {}  # what each unit counts as held
        self._forgetful: set[str] = set()  # units that have restarted and not yet said what they hold
        self._proofs: dict[str, dict[str, ProvenPoints]] = {}
        self._changed: set[str] = set()  # units whose holdings changed at `_changed_s`, not yet judged
        self._changed_s = 0.0
        self._effects: dict[tuple[str, str, int], set[int]] = {}

    @property
    def violations(self) -> tuple[Violation, ...]:
        """The first breach of each rule by each subject, in order of time."""
        return self._log.violations

    @property
    def outside_design(self) -> tuple[Violation, ...]:
        """What followed from less adhesion than the design counts on: told, and no breach of its rules."""
        return self._log.outside

    @property
    def slippery(self) -> tuple[LowAdhesion, ...]:
        """When trains had less than the design adhesion."""
        return tuple(self._rail.stretches)

    @property
    def counts(self) -> Mapping[str, int]:
        """All breaches by name of the checker, repeated ones too."""
        return self._log.counts

    # truth --------------------------------------------------------------------------------------------------

    def entered(self, unit_id: str, length_m: float, edges_under: Sequence[str]) -> None:
        """A train appears; `edges_under` run from the one under its rear to the one under its front.

        Its rear may lie outside the net. Raises ValueError without an edge, KeyError for one not in the net.
        """
        if not edges_under:
            raise ValueError(f"{unit_id} entered on no edge")
        for edge_id in edges_under:
            self._track.piece_of(edge_id)
        self.train_left(unit_id)
        self._bodies[unit_id] = Body(unit_id, length_m, list(edges_under))

    def train_left(self, unit_id: str) -> None:
        """A train is off the line; what its unit held and had proven is over with it."""
        body = self._bodies.pop(unit_id, None)
        if body is None:
            return
        for section_id in body.sections:
            self._occupants[section_id].discard(unit_id)
        self._own.pop(unit_id, None)
        self._proofs.pop(unit_id, None)
        self._crossings.forget(unit_id)
        self._locking.forget_losses(unit_id)
        self._forgetful.discard(unit_id)

    def reversed(self, t_s: float, unit_id: str) -> None:
        """A train changed ends in place: what was proven was proven for the way it no longer goes.

        Raises KeyError for a train that has not entered.
        """
        body = self._bodies[unit_id]
        self._proofs.pop(unit_id, None)
        if body.speed_mps > 0.0:
            text = f"{unit_id} changed ends at {body.speed_mps:.1f} m/s"
            self._log.note(t_s, Checker.NO_JUMP, unit_id, text)
        run_m = body.run_m
        self._track.turn(body)
        self._crossings.turned(body, run_m)

    def observe(
        self,
        t_s: float,
        unit_id: str,
        edge_id: str,
        lane_position_m: float,
        speed_mps: float,
        ran: RunSince = NOT_RUN,
    ) -> None:
        """Where SUMO has a train's front now, and how it `ran` there. Raises KeyError for one that has not entered."""
        body = self._bodies[unit_id]
        body.left = []
        if not math.isfinite(lane_position_m + speed_mps):  # which no comparison would find too great
            text = f"{unit_id} is at {lane_position_m} m of {edge_id}, at {speed_mps} m/s"
            self._log.note(t_s, Checker.NO_JUMP, unit_id, text)
            return
        if t_s > body.seen_s:
            body.acceleration_mps2 = (speed_mps - body.speed_mps) / (t_s - body.seen_s)
        body.seen_s, body.speed_mps = t_s, speed_mps
        if edge_id == body.edge_id and body.front_m <= lane_position_m < body.still_to_m:
            body.front_m = lane_position_m
        elif edge_id != body.turned_from:
            self._settle(t_s, body, edge_id, lane_position_m)
        if edge_id == body.path[-1]:
            self._crossings.observe(t_s, body)
        self._speed.observe(t_s, body, self._rail, ran)
        if speed_mps == 0.0:
            self._rail.train_stood(unit_id)
            self._entries.stands(body)
        for points_id in self._locking.observe(body):
            self._lock_failed(t_s, unit_id, points_id, "did not brake as it is guaranteed to")

    def rail(self, t_s: float, unit_id: str, share: float) -> None:
        """The adhesion under a train is now this share of the dry rail's."""
        body = self._bodies.get(unit_id)
        self._rail.rail(t_s, unit_id, share, 0.0 if body is None else body.speed_mps)

    def bounds(
        self,
        t_s: float,
        unit_id: str,
        true_position_m: float,
        position_m: float,
        bound_behind_m: float,
        bound_ahead_m: float,
    ) -> None:
        """`within-bounds`: the true front lies within what the unit states, to 1 mm; NaN is outside."""
        low_m = position_m - bound_behind_m - RESOLUTION_M
        if not low_m <= true_position_m <= position_m + bound_ahead_m + RESOLUTION_M:
            text = (
                f"{unit_id} is {true_position_m - position_m:+.3f} m from where it believes,"
                f" stated bounds -{bound_behind_m:.3f} to +{bound_ahead_m:.3f} m"
            )
            self._log.note(t_s, Checker.WITHIN_BOUNDS, unit_id, text)

    def alive(
        self, t_s: float, trains: Iterable[TrainAndDisplay], closed_for_nothing: Collection[str] = ()
    ) -> None:
        """`no-dead-state`: trains and closed roads at one moment, every `liveness.LOOKS_EVERY_S` or so."""
        self._liveness.look(t_s, trains)
        self._liveness.look_at_roads(t_s, closed_for_nothing)

    def finish(self, t_s: float, arrived: Mapping[str, bool]) -> None:
        """`everyone-arrives`: `arrived` has every train expected to arrive, and whether it has."""
        self._judge_changes()
        for train, has_arrived in arrived.items():
            if not has_arrived:
                self._log.note(t_s, Checker.EVERYONE_ARRIVES, train, f"{train} has not arrived")

    def _settle(self, t_s: float, body: Body, edge_id: str, front_m: float) -> None:
        """The front came onto another edge, or the rear may have left one."""
        if not self._track.has(edge_id):
            text = f"{body.unit_id} is on {edge_id!r}, which is no edge of the net"
            self._log.note(t_s, Checker.NO_JUMP, body.unit_id, text)
            return
        was, pieces, sections = body.path[-1], body.pieces, body.sections
        on_points = self._points.points_under(body)
        if not self._track.follow(body, edge_id, front_m):
            text = f"{body.unit_id} was on {was} and is at {front_m:.3f} m of {edge_id}: no train runs so"
            self._log.note(t_s, Checker.NO_JUMP, body.unit_id, text)
        body.excepted = body.sections if body.excepted is None else body.excepted & body.sections
        body.overrun &= body.sections
        if self._rail.outside(t_s, body.unit_id):
            body.overrun |= {s for s in body.sections - sections if self._missing(body, s)}
        for piece_id in self._track.touched(body):
            self._check_entry(t_s, body, piece_id, on_points)
        if body.pieces != pieces:
            self._points.check(t_s, body)
            for points_id in on_points - self._points.points_under(body):
                self._locking.is_clear_of(body, points_id)
        if self._entries.watches and body.pieces != pieces:
            self._entries.moved(t_s, body, self._bodies.values())
        if body.sections != sections:
            self._check_alone(t_s, body, sections)
            self._pilots.came_in(t_s, body.unit_id, body.sections - sections)
        self._check_held(t_s, body)

    def _check_entry(self, t_s: float, body: Body, piece_id: str, on_points: Collection[str]) -> None:
        """`proven-before-entry`: the unit has a proof, no older than its grant, for the position.

        Or it lost it when its train could not stop any more, and the route is locked: `judge.locking`. For points that
        the train was on already, the proof counts by which it came.
        """
        unit_id = body.unit_id
        need = self._points.needs(piece_id)
        if need is not None and unit_id not in self._pilots.cut_out:
            proof: ProvenPoints | str | None = self._proofs.get(unit_id, {}).get(need[0])
            if proof is None and need[0] in on_points:
                proof = self._locking.remembered(unit_id, need[0])
                if proof is None:
                    return
            if proof is None:
                proof = self._locking.enters(body, piece_id, need[0])
            section_id, outside = self._points.section_of(need[0]), self._rail.outside(t_s, unit_id)
            token = self._register.token_of(unit_id, section_id)
            if self._points.check_entry(t_s, unit_id, piece_id, proof, token, outside=outside) and outside:
                body.overrun |= {section_id}

    def _check_alone(self, t_s: float, body: Body, before: frozenset[str]) -> None:
        """`one-train-a-section`: no other train has any part in a section that this one came into."""
        for section_id in before - body.sections:
            self._occupants[section_id].discard(body.unit_id)
        for section_id in sorted(body.sections - before):
            occupants = self._occupants.setdefault(section_id, set())
            for other in sorted(occupants - {body.unit_id}):
                text = f"{body.unit_id} came into section {section_id} while {other} is in it"
                pair = " ".join(sorted((body.unit_id, other)))
                outside = section_id in body.overrun | self._bodies[other].overrun
                subject = f"{section_id} {pair}"
                self._log.note(t_s, Checker.ONE_TRAIN_A_SECTION, subject, text, outside=outside)
            occupants.add(body.unit_id)

    def _check_held(self, t_s: float, body: Body) -> None:
        """`inside-holding`: manager and unit both have the unit as holder of all that its train occupies."""
        for section_id in sorted(body.sections):
            missing = self._missing(body, section_id)
            if missing:
                text = f"{body.unit_id} is in section {section_id}: {' and '.join(missing)}"
                subject, outside = f"{section_id} {body.unit_id}", section_id in body.overrun
                self._log.note(t_s, Checker.INSIDE_HOLDING, subject, text, outside=outside)

    def _missing(self, body: Body, section_id: str) -> list[str]:
        """What a train lacks to be in a section; nothing where it holds it, or need not."""
        if section_id in (body.excepted or ()) or body.unit_id in self._pilots.cut_out:
            return []
        unit_id = body.unit_id
        missing = [] if self._register.holds(unit_id, section_id) else ["the block manager did not give it"]
        if section_id not in self._own.get(unit_id, ()) and unit_id not in self._forgetful:
            missing.append("its unit does not hold it")
        return missing

    # journal ------------------------------------------------------------------------------------------------

    def journal(self, entry: events.JournalEntry) -> None:
        """One journal entry, in order. Entries that say nothing to a checker are passed over."""
        if self._changed and entry.t_s > self._changed_s:
            self._judge_changes()
        t_s, who, event = entry.t_s, entry.who, entry.event
        if isinstance(event, events.Sent):  # what has not been heard changes nothing
            return
        self._pilots.see(event)
        self._crossings.see(entry, self._bodies.values())
        # as where it was put on the line
        if isinstance(event, events.CutIn) and event.unit_id in self._bodies:
            self._bodies[event.unit_id].excepted = self._bodies[event.unit_id].sections
            self._forgets(event.unit_id)
        if isinstance(event, events.TookEffect):
            self._took_effect(t_s, who, event)
        elif who == events.MANAGER:
            self._of_manager(t_s, event)
        elif who == events.WORLD:
            self._of_world(t_s, event)
        else:
            self._of_unit(t_s, who, event)

    def _of_manager(self, t_s: float, event: events.Event) -> None:
        match event:
            case events.Granted():
                self._register.granted(t_s, event.unit_id, event.route_id, event.section_ids, event.token)
            case events.Freed(unit_id=unit_id, section_ids=section_ids):
                self._register.freed(unit_id, section_ids)
                self._note_change(t_s, unit_id)
            case events.Accepted() | events.ConfirmedByHand():
                self._register.accepted(t_s, event.unit_id, event.section_ids)
                self._taken(t_s, event.unit_id)
            case events.Outside(unit_id=unit_id):
                self._register.outside(unit_id)
                self._outside(t_s, unit_id)
            case events.Barred(unit_id=unit_id):
                self._register.barred(unit_id)
            case events.TakenBack(unit_id=unit_id):
                self._register.taken_back(unit_id)
            case events.PictureChanged(stage="defined"):
                self._register.defined()
            case events.Started(epoch=epoch):
                self._register.restarted(self._unit_ids, epoch)
            case _:
                pass

    def _of_world(self, t_s: float, event: events.Event) -> None:
        bodies = self._bodies.values()
        match event:
            case (
                events.PointsMoving(points_id=points_id)
                | events.PointsUnlocked(points_id=points_id)
                | events.PointsForced(points_id=points_id)
            ):
                for unit_id in self._locking.points_stirred(points_id):
                    self._lock_failed(t_s, unit_id, points_id, "they did not stay locked")
            case _:
                pass
        match event:
            case events.PointsMoving(points_id=points_id):
                self._points.moving(t_s, points_id, bodies)
            case events.PointsLocked(points_id=points_id, position=position):
                self._points.locked(t_s, points_id, position, bodies)
            case events.PointsUnlocked(points_id=points_id):
                self._points.unlocked(t_s, points_id, bodies)
            case events.PointsForced(points_id=points_id):
                self._points.points_lost(t_s, points_id, bodies)
            case events.Unsafe(unit_id=unit_id):
                body = self._bodies.get(unit_id)
                if self._rail.outside(t_s, unit_id) or (body is not None and body.overrun):
                    text = f"{unit_id} {event.text}"
                    self._log.note_outside(t_s, "unsafe", text, text)
            # `sumo-collision`: SUMO's own check found two trains in one place
            case events.Collision(text=text):
                self._log.note(t_s, Checker.SUMO_COLLISION, text, text)
            case events.VehicleStruck(text=text):
                self._log.note(t_s, Checker.SUMO_COLLISION, text, text)
            case _:
                pass

    def _of_unit(self, t_s: float, unit_id: str, event: events.Event) -> None:
        match event:
            case events.Holds(section_ids=section_ids):
                self._holds(t_s, unit_id, frozenset(section_ids))
            case events.Reported(section_ids=section_ids):
                self._reported(t_s, unit_id, frozenset(section_ids))
            case events.Proven(points_id=points_id, position=position, token=token):
                self._proofs.setdefault(unit_id, {})[points_id] = ProvenPoints(position, token)
                self._locking.forget_losses(unit_id, (points_id,))
            case events.ProofDropped(points_id=points_id):
                self._lost(unit_id, (points_id,))
            case events.UnitRestarted():
                self._forgets(unit_id)
                self._lost(unit_id, tuple(self._proofs.get(unit_id, ())))
            case _:
                pass

    def _forgets(self, unit_id: str) -> None:
        """A unit knows nothing of what it held, until it says something."""
        self._forgetful.add(unit_id)
        self._own.pop(unit_id, None)

    def _holds(self, t_s: float, unit_id: str, sections: frozenset[str]) -> None:
        """`release-behind-rear`, first half: a unit drops no section that its train still occupies."""
        before = self._own.get(unit_id, sections)
        self._own[unit_id] = sections
        self._forgetful.discard(unit_id)
        body = self._bodies.get(unit_id)
        if body is not None and self._register.knows(unit_id):
            body.excepted = frozenset()
        proofs = self._proofs.get(unit_id, {})
        for points_id in [p for p in proofs if self._points.section_of(p) not in sections]:
            del proofs[points_id]
        gone = [p for p in self._points.ids if self._points.section_of(p) not in sections]
        self._locking.forget_losses(unit_id, gone)
        self._check_release(t_s, unit_id, before - sections, "drops")
        self._note_change(t_s, unit_id)

    def _lost(self, unit_id: str, points_ids: Iterable[str]) -> None:
        """The unit has no proofs any more of these points."""
        proofs = self._proofs.get(unit_id, {})
        lost = {points_id: proofs.pop(points_id) for points_id in points_ids if points_id in proofs}
        body = self._bodies.get(unit_id)
        if body is not None:
            self._locking.proofs_lost(body, lost)

    def _lock_failed(self, t_s: float, unit_id: str, points_id: str, why: str) -> None:
        """`proven-before-entry` once more: a train came onto points by a proof that it had lost, and that fails it."""
        outside = self._points.section_of(points_id) in self._bodies[unit_id].overrun
        outside = outside or self._rail.outside(t_s, unit_id)
        self._points.lock_failed(t_s, unit_id, points_id, why, outside=outside)

    def _reported(self, t_s: float, unit_id: str, sections: frozenset[str]) -> None:
        """`release-behind-rear`, second half: a report lists every section that the train still occupies."""
        body = self._bodies.get(unit_id)
        if body is not None:
            self._check_release(t_s, unit_id, body.sections - sections, "gives back")

    def _check_release(self, t_s: float, unit_id: str, gone: Iterable[str], verb: str) -> None:
        body = self._bodies.get(unit_id)
        if body is None:
            return
        for section_id in sorted((body.sections - (body.excepted or frozenset())).intersection(gone)):
            text = f"{unit_id} {verb} section {section_id} while its train is in it"
            self._log.note(t_s, Checker.RELEASE_BEHIND_REAR, f"{section_id} {unit_id}", text)

    def _took_effect(self, t_s: float, who: str, event: events.TookEffect) -> None:
        """`telegram-once`: no telegram of one boot of its source takes effect twice at a receiver, whoever it is."""
        source, epoch, sequence = event.source, event.epoch, event.sequence
        done = self._effects.setdefault((who, source, epoch), set())
        if sequence in done:
            text = f"telegram {sequence} of {source}, boot {epoch}, took effect again at {who}"
            self._log.note(t_s, Checker.TELEGRAM_ONCE, f"{who} {source} {epoch} {sequence}", text)
        done.add(sequence)

    def _taken(self, t_s: float, unit_id: str) -> None:
        """The manager has the unit on the line, by its own word or by that of persons."""
        body = self._bodies.get(unit_id)
        if body is None:
            return
        if unit_id in self._forgetful or self._own.get(unit_id):
            body.excepted = frozenset()
        self._note_change(t_s, unit_id)

    def _outside(self, t_s: float, unit_id: str) -> None:
        """The manager has the unit as off the line: its train may stand nowhere."""
        body = self._bodies.get(unit_id)
        if body is not None:
            body.excepted = frozenset()
            self._note_change(t_s, unit_id)

    def _note_change(self, t_s: float, unit_id: str) -> None:
        """A standing train is judged too, but once all entries of this moment are in."""
        self._changed.add(unit_id)
        self._changed_s = t_s

    def _judge_changes(self) -> None:
        for unit_id in sorted(self._changed):
            body = self._bodies.get(unit_id)
            if body is not None:
                self._check_held(self._changed_s, body)
        self._changed.clear()
