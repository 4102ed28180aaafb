"""Every switch of `switches` makes `branchline reproduce` fail with exit code 1, in rows that are named here."""

import json
from dataclasses import dataclass
from typing import Final

import pytest
from typer.testing import CliRunner

from branchline.cli import app
from study.outcome import Outcome
from tests.nightly import others_nightly
from tests.papers.switches import SWITCHES


@dataclass(frozen=True)
class Guarded:
    """What `off` takes away, and the rows of a reproduction that must say so."""

    name: str
    off: str
    rows: tuple[str, ...]


GUARDED: Final = (
    Guarded("oda-table4", "prediction_removed", ("law without prediction",)),
    Guarded(
        "oda-table4",
        "redrawing_removed",
        ("law without redrawing", "one target, error positive, 20 m", "cells that agree"),
    ),
    Guarded(
        "oda-table4",
        "feed_forward_removed",
        ("law without the pattern's own deceleration", "two targets, error negative, 100 m"),
    ),
    Guarded("oda-table4", "resistance_not_taken_off", ("law without gradient and running resistance",)),
    Guarded("oda-table4", "soft_end_removed", ("law without the soft end",)),
    Guarded(
        "oda-table4",
        "gain_0",
        ("law without gain", "gain found as in 3.2.3, 1/s", "two targets, error negative, 100 m"),
    ),
    Guarded("oda-table4", "frame_error_reversed", ("estimate ahead of the train while a sign is seen, m",)),
    Guarded(
        "oda-table4",
        "null_method_has_beacons_and_signs",
        ("null method, wheels alone, no beacon and no sign: cells that agree",),
    ),
    Guarded(
        "oda-tuning",
        "mode_replaced_by_mean",
        (
            "of 12 trains, those that go by what is right to one step of the grid",
            "trains whose mean lies elsewhere than their mode",
            "root mean square distance of held-out stops from the mark, m",
        ),
    ),
    Guarded(
        "oda-tuning",
        "disturbed_stops_kept",
        (
            "of 12 trains, those that go by what is right to one step of the grid",
            "stops of full trains that were learned from",
            "root mean square distance of held-out stops from the mark, m",
        ),
    ),
    Guarded(
        "oda-tuning",
        "six_points_off_their_centre",
        ("of 12 trains, those in which both methods give the same mode",),
    ),
    Guarded("stop-statistics", "feed_forward_removed", ("stops within 1 m",)),
    Guarded(
        "stop-statistics",
        "shares_of_the_variance_by_chance",
        (
            "share of the variance: from all stops, and from the factor alone",
            "all factors one by one, share of the variance",
        ),
    ),
    Guarded("stop-window", "prediction_removed", ("greatest speed of the set, km/h",)),
    Guarded(
        "stop-window", "brakes_beyond_the_stated_range", ("random stops from the set that end within 1 m",)
    ),
    Guarded("stop-window", "set_taken_too_large", ("random stops from the set that end within 1 m",)),
    Guarded(
        "stop-window",
        "set_taken_too_small",
        (
            "speeds at which a brake misses within 4 steps outside; at which the set ends as for any law",
            "stops from just outside, by brakes at the ends of their ranges, that miss the window",
        ),
    ),
    Guarded(
        "position-compare",
        "creeping_reflections_claimed_to_be_held",
        ("GNSS, 3 m: reflections that creep up",),  # the other sensors of "all" hold it
    ),
    Guarded("position-compare", "faults_do_nothing", ("faults that leave their run as it was",)),
)


def rows_that_fail(name: str) -> tuple[int, set[str]]:
    """Exit code of a quick reproduction, and its rows that did not pass."""
    result = CliRunner().invoke(app, ["reproduce", name, "--quick", "--json"])
    found = json.loads(result.stdout)
    return result.exit_code, {row["case"] for row in found["rows"] if not row["passed"]}


@pytest.mark.nightly  # each has a test of its own that its short slice passes
@pytest.mark.parametrize("name", sorted({guarded.name for guarded in GUARDED}))
def test_with_everything_in_place_every_row_passes(name: str) -> None:
    assert rows_that_fail(name) == (0, set())


LONG: Final = ("stop-window", "oda-tuning", "stop-statistics")
# The first switch of each other reproduction is tried in every run.
FIRST: Final = {guarded.name: guarded for guarded in reversed(GUARDED) if guarded.name not in LONG}


@pytest.mark.parametrize(
    "guarded",
    others_nightly(GUARDED, tuple(FIRST.values())),
    ids=lambda guarded: f"{guarded.name}: {guarded.off}",
)
def test_what_is_taken_away_is_missed(guarded: Guarded, monkeypatch: pytest.MonkeyPatch) -> None:
    SWITCHES[guarded.off](monkeypatch)
    code, failed = rows_that_fail(guarded.name)
    assert code == Outcome.BROKEN.code
    assert set(guarded.rows) <= failed, failed


def test_every_switch_is_guarded() -> None:
    assert {guarded.off for guarded in GUARDED} == set(SWITCHES)
