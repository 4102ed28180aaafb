"""What a train, leg, layover or hour took and where it went, as fields of its row (電力量の内訳)."""

from __future__ import annotations

import math
from collections.abc import Sequence

from network.units import J_PER_KWH
from simulation.result import PARTS, EnergyRecord
from vehicle.train_file import RegenerationReceiver


def taken(drawn_kwh: Sequence[float], receiver: RegenerationReceiver) -> dict[str, float]:
    """The fields of `study.record.energy.Taken` of traction, regenerated and auxiliary.

    Net is less what came back, and from resistors nothing does.
    """
    traction_kwh, regenerated_kwh, auxiliary_kwh = drawn_kwh
    back_kwh = 0.0 if receiver is RegenerationReceiver.RESISTORS else regenerated_kwh
    return {
        "traction_kwh": traction_kwh,
        "auxiliary_kwh": auxiliary_kwh,
        "regenerated_kwh": regenerated_kwh,
        "net_kwh": traction_kwh + auxiliary_kwh - back_kwh,
    }


def spent(records: Sequence[EnergyRecord], receiver: RegenerationReceiver) -> dict[str, float]:
    """The fields of `study.record.energy.Spent` of some records together.

    What resistors burn was braked by the motors, so it is a loss of regeneration; it could have come back.
    """
    names = [part.removesuffix("_j") for part in PARTS]
    burnt_j = math.fsum(r.regenerated_j for r in records if receiver is RegenerationReceiver.RESISTORS)
    sums_j = {name: math.fsum(getattr(r.parts, f"{name}_j") for r in records) for name in names}
    sums_j["regeneration_loss"] += burnt_j
    sums_j["rejected"] = math.fsum(r.rejected_j for r in records) + burnt_j
    sums_j["residual"] = math.fsum(r.residual_j for r in records)
    drawn = ("traction_j", "regenerated_j", "auxiliary_j")
    whole = taken([sum(getattr(r, name) for r in records) / J_PER_KWH for name in drawn], receiver)
    return whole | {f"{name}_kwh": joules / J_PER_KWH for name, joules in sums_j.items()}
