"""What a train, leg, layover or hour took and where it went, as fields of its row (電力量の内訳)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from network.units import J_PER_KWH
from simulation.result import COUNTED, DRAWN, REJECTED, EnergyRecord
from vehicle.train_file import RegenerationReceiver


def drawn_kwh(joules: Mapping[str, float], receiver: RegenerationReceiver) -> dict[str, float]:
    """The fields of `study.record.energy.EnergyDrawn` of what was counted, J by the names of DRAWN.

    Net is less what came back, and from resistors nothing does.
    """
    kwh = {f"{name}_kwh": joules[name] / J_PER_KWH for name in DRAWN}
    back_kwh = 0.0 if receiver is RegenerationReceiver.RESISTORS else kwh["regenerated_kwh"]
    return kwh | {"net_kwh": kwh["traction_kwh"] + kwh["auxiliary_kwh"] - back_kwh}


def spent_kwh(records: Sequence[EnergyRecord], receiver: RegenerationReceiver) -> dict[str, float]:
    """The fields of `study.record.energy.EnergySpent` of some records together.

    What resistors burn was braked by the motors, so it is a loss of regeneration; it could have come back.
    """
    sums_j = {name: math.fsum(record.counted_j[name] for record in records) for name in COUNTED}
    if receiver is RegenerationReceiver.RESISTORS:
        sums_j["regeneration_loss"] += sums_j["regenerated"]
        sums_j[REJECTED] += sums_j["regenerated"]
    sums_j["residual"] = math.fsum(record.residual_j for record in records)
    return {f"{name}_kwh": joules / J_PER_KWH for name, joules in sums_j.items()} | drawn_kwh(
        sums_j, receiver
    )
