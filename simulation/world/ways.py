"""The hops of every set's day as its unit predicts them: what each takes of its battery. Made once, before the run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from network.model import Line
from network.path import Path
from network.profile import profile_of
from onboard.driving.pattern import pattern_of
from onboard.mission import Mission
from onboard.reach import BatteryHop, Ground, OffLine, SetWays, hops_of, run_of
from onboard.records import BehaviourRow
from simulation.setup import Setup, behaviour_row
from simulation.world.roster import Duty
from vehicle.records import TrainRow


def ways_of(setup: Setup, drawn: Mapping[str, Iterable[Duty]]) -> dict[str, SetWays]:
    """The hops of every set, by stock id, at the scenario's mean load and by what its unit believes."""
    known: dict[tuple[object, ...], tuple[float, float]] = {}
    grounds: dict[tuple[object, ...], Ground] = {}
    return {
        stock_id: _ways(setup, stock_id, tuple(duties), known, grounds) for stock_id, duties in drawn.items()
    }


def _ways(
    setup: Setup,
    stock_id: str,
    duties: tuple[Duty, ...],
    known: dict[tuple[object, ...], tuple[float, float]],
    grounds: dict[tuple[object, ...], Ground],
) -> SetWays:
    kind = setup.believed_train(stock_id)
    behaviour = behaviour_row(setup.driving, kind.row[0]).reshape(1).view(np.recarray)[0]
    train = kind.row.view(np.recarray)[0]
    dwell_s = setup.unit.duty.dwell_min_s
    hops: list[BatteryHop] = []
    first: dict[str, int] = {}
    for duty, following in zip_longest(duties, duties[1:]):
        mission = duty.mission
        key = (kind.id, mission.path.piece_ids)
        if key not in grounds:
            grounds[key] = ground_of(setup.believed_line, mission.path, train, behaviour)
        runs = _runs_of(setup, key, mission, train, behaviour, grounds[key], known)
        stays = following.mission if following is not None and not duty.leaves else None
        first[mission.number] = len(hops)
        auxiliary_w = float(train.auxiliary_power_w)
        off = _off_line(setup, mission.number)
        stays_on_w = auxiliary_w if setup.battery is None else setup.battery.shed_to_kw * 1e3
        waits_w = max(auxiliary_w - stays_on_w, 0.0)
        hops += hops_of(setup.believed_line, mission, runs, auxiliary_w, waits_w, dwell_s, stays, off)
    return SetWays(tuple(hops), first)


def _off_line(setup: Setup, number: str) -> OffLine:
    """What a set does off the line after one of its trains."""
    if setup.battery is None:
        return OffLine()
    beyond = setup.battery.beyond_of(number)
    return OffLine(beyond.takes_j, charges=beyond.charge_min > 0.0 and beyond.charge_kw > 0.0)


def _runs_of(
    setup: Setup,
    key: tuple[object, ...],
    mission: Mission,
    train: TrainRow,
    behaviour: BehaviourRow,
    ground: Ground,
    known: dict[tuple[object, ...], tuple[float, float]],
) -> list[tuple[float, float]]:
    """Time (s) and energy (J) of each run of a mission; the same run at the same times is predicted once."""
    found: list[tuple[float, float]] = []
    for here, there in zip(mission.targets, mission.targets[1:], strict=False):
        times = (here.departure_s, there.arrival_s, there.departure_s)
        since = 0.0 if here.departure_s is None else here.departure_s
        run = (*key, here.mark_m, there.mark_m, *(None if t is None else t - since for t in times))
        if run not in known:
            known[run] = run_of(
                train,
                behaviour,
                setup.load.load_share_mean,
                ground,
                (here, there),
                setup.unit.duty.dwell_min_s,
                setup.unit.time_margin_s,
            )
        found.append(known[run])
    return found


def ground_of(line: Line, path: Path, train: TrainRow, behaviour: BehaviourRow) -> Ground:
    """A unit's path database of a path: what its predictions need of it."""
    rows = path_database(line, path, train, behaviour)
    return Ground(np.ascontiguousarray(rows["climb_m"]), np.ascontiguousarray(rows["driving_mps"]))


def path_database(line: Line, path: Path, train: TrainRow, behaviour: BehaviourRow) -> NDArray[np.void]:
    """A unit's path database of a path: rows of PATTERN by the metre, shape (n,)."""
    profile = profile_of(line, path)
    return pattern_of(
        np.ascontiguousarray(profile["elevation_m"]),
        np.ascontiguousarray(profile["turn_rad"]),
        np.ascontiguousarray(profile["limit_mps"]),
        train,
        behaviour,
    )
