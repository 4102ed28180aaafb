"""Writes docs/losses.md from a shipped train with a map of losses: `python -m documents.losses [FILE]`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from documents.page import write_page
from network.model import Line
from network.profile import profile_of
from network.units import J_PER_KWH
from onboard.driving.pattern import limit_for_train
from scenario.scenario import load_scenario
from study.measures.running_times import STEP_S, TrainHop, planned_hops
from vehicle.adhesion import DRY, adhesion_coefficient
from vehicle.losses import running_motors
from vehicle.mass import GRAVITY_MPS2, mass_kg
from vehicle.resistance import climb_m
from vehicle.running_time import predicted_run
from vehicle.traction import full_force_n, motored_grip_n
from vehicle.train_file import load_train, shipped_train
from vehicle.wire import wire_power_w

FILE: Final = Path("docs/losses.md")
TRAIN: Final = "ev_e301_losses"
SCENARIO: Final = "karasuyama_weekday"
DAY: Final = ("321M", "322M")  # a train down and a train up that stop everywhere
SPEEDS_KMH: Final = (10.0, 20.0, 28.5, 40.0, 50.0, 65.0, 80.0, 100.0)
LOADS: Final = (0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0)
LOAD_SHARE: Final = 0.2
DECELERATION_MPS2: Final = 0.7
HALVINGS: Final = 30

HEAD: Final = """\
# What motors and inverters lose

Made by `make docs` from `vehicle/losses.py` and `vehicle/trains/ev_e301_losses.toml`; do not edit. The law stands
in that module, why it has this form in [decision 024](decisions/024-losses-and-motors.md); the figures of the train
are assumed.

Efficiency from the battery to the rim, in percent, by speed and by share of the full force there. First with all four
motors; behind it with as many as lose least, and how many those are.
"""
BRAKE: Final = """
The electric brake, from the rim to the battery, all motors. At little force and low speed it takes more than it gives.
"""
HOPS: Final = """
On a hop: the energy of one train down and one up, run from stand to stand in the time of the timetable of
`karasuyama_weekday` at one cruising speed, without coasting ({share:.0%} of a full load, auxiliaries apart; below 0
more came back than was drawn). Cutting motors out saves where a speed is held at light load, pulling or braking.

| hop | km | time, s | all motors, kWh | cut out, kWh | saved, kWh |
|---|---|---|---|---|---|
"""


def document() -> str:
    """The whole text."""
    row = load_train(shipped_train(TRAIN)).row
    cutting = np.array(row)
    cutting["motors_cut_out"] = 1.0
    hops = HOPS.format(share=LOAD_SHARE)
    parts = (
        HEAD,
        *_pulling(row[0], cutting[0]),
        BRAKE,
        *_braking(row[0]),
        hops.rstrip("\n"),
        *_hops(row, cutting),
        "",
    )
    return "\n".join(parts)


def _head(first: str) -> Iterator[str]:
    yield f"| {first} | " + " | ".join(f"{load:.0%}" for load in LOADS) + " |"
    yield "|---" * (len(LOADS) + 1) + "|"


def _pulling(all_run: Any, cutting: Any) -> Iterator[str]:  # noqa: ANN401
    yield from _head("km/h, pulling")
    for kmh in SPEEDS_KMH:
        mps = kmh / 3.6
        full_n = float(full_force_n(all_run, 0.0, mps))
        cells: list[str] = []
        for load in LOADS:
            force_n = load * full_n
            shares = (
                100.0 * force_n * mps / wire_power_w(train, 1.0, force_n, mps) for train in (all_run, cutting)
            )
            grip_n = motored_grip_n(
                cutting, mass_kg(cutting, 0.0) * GRAVITY_MPS2, adhesion_coefficient(cutting, DRY, mps)
            )
            running = running_motors(cutting, 1.0, force_n, mps, grip_n)
            cells.append("{:.1f} / {:.1f} ({:.0f})".format(*shares, running))
        yield f"| {kmh:g} | " + " | ".join(cells) + " |"


def _braking(train: Any) -> Iterator[str]:  # noqa: ANN401
    yield from _head("km/h, braking")
    for kmh in SPEEDS_KMH:
        mps = kmh / 3.6
        full_n = float(full_force_n(train, 0.0, mps))
        shares = (
            -100.0 * wire_power_w(train, 1.0, -load * full_n, mps) / (load * full_n * mps) for load in LOADS
        )
        yield f"| {kmh:g} | " + " | ".join(f"{share:.1f}" for share in shares) + " |"


def _hops(all_run: NDArray[np.void], cutting: NDArray[np.void]) -> Iterator[str]:
    setup = load_scenario(SCENARIO).setup
    sums = np.zeros(2)
    for hop in planned_hops(setup):
        if hop.mission.number not in DAY:
            continue
        time_s, all_j, cut_j = _run(setup.line, hop, all_run, cutting)
        sums += all_j, cut_j
        km = abs(hop.there.mark_m - hop.here.mark_m) / 1000.0
        ends = f"{hop.here.station_id} – {hop.there.station_id}"
        yield f"| {ends} | {km:.1f} | {time_s:.0f} | " + _saved(all_j, cut_j)
    yield "| all | | | " + _saved(*sums)
    yield f"\nThat is {100.0 * (1.0 - sums[1] / sums[0]):.1f} % of what the motors took, less what they gave back."


def _run(line: Line, hop: TrainHop, *trains: NDArray[np.void]) -> tuple[float, ...]:
    """Planned time, s, and the energy of each train without auxiliaries, J, at the cruising speed that takes it."""
    profile = profile_of(line, hop.mission.path)
    kind = trains[0].view(np.recarray)[0]
    climbs_m = np.ascontiguousarray(climb_m(kind, profile["elevation_m"], profile["turn_rad"]))
    limit_mps = np.ascontiguousarray(limit_for_train(profile["limit_mps"], kind))

    def run(train: NDArray[np.void], cruise_mps: float) -> tuple[float, float]:
        ends_m = (hop.here.mark_m, hop.there.mark_m)
        ran: tuple[float, float] = predicted_run(
            train[0], LOAD_SHARE, climbs_m, limit_mps, *ends_m, cruise_mps, DECELERATION_MPS2, STEP_S
        )
        return ran

    planned_s = hop.due_s - hop.leaves_s
    slow_mps, fast_mps = 5.0, float(limit_mps.max())
    for _ in range(HALVINGS):
        middle_mps = 0.5 * (slow_mps + fast_mps)
        late = run(trains[0], middle_mps)[0] > planned_s
        slow_mps, fast_mps = (middle_mps, fast_mps) if late else (slow_mps, middle_mps)
    rans = [run(train, fast_mps) for train in trains]
    auxiliary_j = float(kind.auxiliary_power_w) * rans[0][0]
    return rans[0][0], *(net_j - auxiliary_j for _, net_j in rans)


def _saved(all_j: float, cut_j: float) -> str:
    return f"{all_j / J_PER_KWH:.2f} | {cut_j / J_PER_KWH:.2f} | {(all_j - cut_j) / J_PER_KWH:.2f} |"


if __name__ == "__main__":
    write_page(document, FILE)
