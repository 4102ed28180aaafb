"""Substitute working where trains do not have the ways of the plan any more: by another track, or ended early."""

from pathlib import Path
from typing import Final

from simulation.events import PointsSetByHand, Unsafe
from tests.plain import run_on_plain

TRACK_CHANGED: Final = Path(__file__).parent / "chaos/replays/wide_616/wide_616.toml"


def test_points_are_set_for_the_track_where_the_train_stands() -> None:
    """D2 was ordered to track 2 at B, whose points P10 are reverse, before the manager failed; planned was track 1."""
    run = run_on_plain(TRACK_CHANGED)
    events = [entry.event for entry in run.result.journal.entries]
    at_p10 = [e.position.value for e in events if isinstance(e, PointsSetByHand) and e.points_id == "P10"]
    assert at_p10 == ["reverse"]
    assert not [event for event in events if isinstance(event, Unsafe)] and not run.broken
