"""What is so in a state of the train, and of the gate: asked by the search and by who recounts."""

from __future__ import annotations

from collections.abc import Iterable

from onboard.crossings.machine import CrossingPhase
from verify.crossing.gate import ArmsAt, GateFault, GateState, Rider
from verify.crossing.rider import ANNOUNCED, ON_ROAD, RiderState, TrainAt, committed
from verify.on_air import InAir
from wayside.level_crossing import CrossingState

GateKey = tuple[object, ...]


def gate_key(gate: GateState) -> GateKey:
    """A gate without the fixed data of its device, to be told from others."""
    device = gate.device
    approaches = tuple(sorted(device.approaches.items()))
    known = device.memory, device.state, device.detected
    times_s = device.lit_s, device.deadline_s, device.believed_s
    return (*gate._replace(device=None), approaches, *known, *times_s)  # type: ignore[arg-type]


def rests(gate: GateState) -> bool:
    """Whether the road is open, nobody is announced, and nothing fails."""
    device = gate.device
    at_rest = gate.power and device.state is CrossingState.OPEN and not device.approaches
    return at_rest and gate.arms is ArmsAt.UP and not gate.closes and gate.fault is GateFault.NONE


def seen_of(rider: RiderState, down: Iterable[InAir], *, cut: bool) -> Rider:
    """What the judge sees of the train; `down`: telegrams on their way to it."""
    view = rider.view
    relies = view is not None and view.phase in (CrossingPhase.PROVEN, CrossingPhase.PASSING)
    proven = relies and view is not None and view.until_s > 0.0
    at_road = rider.at in (TrainAt.BRAKING, TrainAt.PERHAPS_BEFORE, *ON_ROAD)
    says = rider.power and rider.known and rider.at is not TrainAt.AWAY and not cut
    return Rider(
        guarded=proven or (rider.at in ON_ROAD and rider.by_proof),
        proven=proven,
        committed=committed(rider),
        comes=proven or at_road or (says and view is not None and view.phase in ANNOUNCED),
        believes=proven or any(getattr(telegram.message, "closed", False) for telegram in down),
    )


def has_passed(rider: RiderState) -> bool:
    """Whether the train is over the road, and its unit has nothing more to say."""
    view = rider.view
    quiet = view is None or (view.phase is CrossingPhase.AHEAD and not view.forgot)
    return rider.at is TrainAt.PASSED and rider.power and rider.known and quiet
