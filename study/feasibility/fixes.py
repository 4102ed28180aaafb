"""Where units get to know where they are, by what their train carries: each place with the half-width that it leaves.

What runs show is simplified to places: a tag or a beacon with a number at its own; satellites wherever the sky is
open, by the protection level; curvature at the end of each transition curve; markers at their first row; for trains
that read no tags the driver's eye at each stop. Bounds span a tag and as many before it as may lie together (decision
035), so that it leaves what these leave. Nothing here is simulated.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from network.path import Path
from network.profile import OPEN_SKY, profile_of
from onboard.fixes import EYE_WITHIN_M
from onboard.mission import Mission
from onboard.unit_records import UnitParameters
from simulation.settings import PositionSensor
from simulation.setup import Setup

SKY_EVERY_M: Final = 50.0  # a receiver has one a second
CURVATURE_WITHIN_M: Final = 4.0  # assumed: what runs show behind a curve
MARKERS_WITHIN_M: Final = 1.0  # assumed: what runs show behind a group that was read
TRANSITION_PER_M2: Final = 1.0e-5  # curvature that changes faster than this can be told from another place's
TRANSITION_LEAST_M: Final = 25.0  # Harada and others, 3.4: of transition curve in what is compared


class PositionKnown(NamedTuple):
    """From here on a train knows where it is, within so much either way, m; before the bounds grow again."""

    at_m: float
    within_m: float


def fixes_on(setup: Setup, stock_id: str, mission: Mission) -> tuple[PositionKnown, ...]:
    """All of a mission's path (m along it), in their order."""
    carried, path = setup.sensors.carried_by(stock_id), mission.path
    found: list[PositionKnown] = []
    if PositionSensor.TAGS in carried:
        found += _tags(setup, mission)
    else:
        found += [PositionKnown(target.mark_m, EYE_WITHIN_M) for target in mission.targets]
    if PositionSensor.BEACONS in carried:
        found += _beacons(setup, path)
    if PositionSensor.GNSS in carried:
        found += _satellites(setup, path)
    if PositionSensor.CURVATURE in carried:
        found += [PositionKnown(at_m, CURVATURE_WITHIN_M) for at_m in _transitions(setup, path)]
    if PositionSensor.LIDAR in carried:
        found += _markers(setup, path)
    return tuple(sorted(found))


def measured_growth(unit: UnitParameters) -> float:
    """Growth of the bounds once tags have measured the wheels: what varies on the way, there and where they did."""
    return min(2.0 * unit.wheel_varies_share, unit.wheel_error_share)


def _tags(setup: Setup, mission: Mission) -> Iterator[PositionKnown]:
    """Each tag with the growth since the last one of which one at least is right; before that, since the first mark."""
    unit = setup.unit
    share = measured_growth(unit)
    at_m = [tag.position_m for tag in mission.tags]
    known_m = [*[mission.targets[0].mark_m] * unit.tags_wrong_together, *at_m]
    for tag_m, since_m in zip(at_m, known_m, strict=False):
        yield PositionKnown(tag_m, unit.tag_accuracy_m + share * max(tag_m - since_m, 0.0))


def _markers(setup: Setup, path: Path) -> Iterator[PositionKnown]:
    for group in setup.believed_line.markers.values():
        if group.piece_id in path and path.direction in group.directions:
            yield PositionKnown(path.to_path_m(group.piece_id, group.position_m), MARKERS_WITHIN_M)


def _beacons(setup: Setup, path: Path) -> Iterator[PositionKnown]:
    for beacon in setup.believed_line.beacons.values():
        if (
            beacon.tells_id
            and beacon.used
            and beacon.piece_id in path
            and path.direction in beacon.directions
        ):
            at_m = path.to_path_m(beacon.piece_id, beacon.position_m)
            yield PositionKnown(at_m, setup.unit.tag_accuracy_m)


def _satellites(setup: Setup, path: Path) -> Iterator[PositionKnown]:
    sky = profile_of(setup.line, path)["sky"]
    within_m = setup.gnss.receiver.protection_m
    for at_m in np.arange(0.0, path.length_m, SKY_EVERY_M):
        if sky[int(at_m)] >= OPEN_SKY:
            yield PositionKnown(float(at_m), within_m)


def _transitions(setup: Setup, path: Path) -> Iterator[float]:
    """Where a transition curve that is long enough ends."""
    heading = profile_of(setup.believed_line, path)["heading_rad"]
    changes = np.abs(np.diff(heading, 2)) > TRANSITION_PER_M2
    run_m = 0
    for at, change in enumerate([*changes.tolist(), False]):
        if not change and run_m >= TRANSITION_LEAST_M:
            yield float(at + 1)
        run_m = run_m + 1 if change else 0
