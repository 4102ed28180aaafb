"""Where the energy of a train, leg or layover went, as columns of its table (電力量の内訳)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from network.units import J_PER_KWH
from simulation.result import PARTS, EnergyRecord
from vehicle.train_file import Receiver


def parts_columns(
    groups: Sequence[Sequence[EnergyRecord]], receivers: Iterable[Receiver]
) -> dict[str, list[object]]:
    """The columns of `study.run.tables.PARTS_KWH`, one row a group of records, each with its receiver.

    What resistors burn was braked by the motors, so it is a loss of regeneration; it could have come back.
    """
    names = [part.removesuffix("_j") for part in PARTS]
    columns: dict[str, list[object]] = {f"{name}_kwh": [] for name in (*names, "rejected", "residual")}
    for records, receiver in zip(groups, receivers, strict=True):
        burnt_j = math.fsum(r.regenerated_j for r in records if receiver is Receiver.RESISTORS)
        sums_j = {name: math.fsum(getattr(r.parts, f"{name}_j") for r in records) for name in names}
        sums_j["regeneration_loss"] += burnt_j
        sums_j["rejected"] = math.fsum(r.rejected_j for r in records) + burnt_j
        sums_j["residual"] = math.fsum(r.residual_j for r in records)
        for name, joules in sums_j.items():
            columns[f"{name}_kwh"].append(joules / J_PER_KWH)
    return columns
