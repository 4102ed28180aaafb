"""A slow stretch is left by a train that believes itself 20 m ahead of where it is, with bounds of 70 m."""

from dataclasses import replace
from pathlib import Path

import polars as pl
import pytest

from onboard.notes import Intervention
from scenario.scenario import load_scenario
from tests.plain import run_on_plain
from tests.system.switchboard import FOLDER, TRAIN_M
from tests.system.switches_compiled import run_with

BLIND = str(FOLDER / "limit_left_blind.toml")
FROM_M, TO_M, LIMIT_MPS = 2900.0, 3000.0, 5.0 / 3.6
UNTIL_S = 5.9 * 3600.0  # it has left it by then


def test_it_keeps_the_limit_until_its_rear_has_truly_left_it() -> None:
    loaded = load_scenario(BLIND)
    run = run_on_plain(replace(loaded, setup=replace(loaded.setup, until_s=UNTIL_S)))
    assert run.broken == ()
    assert not any(isinstance(entry.event, Intervention) for entry in run.result.journal.entries)
    front, way = pl.col("kilometrage_m"), run.tables.trajectory
    assert way.filter(pl.col("train") == "321M")["kilometrage_m"].max() > TO_M + TRAIN_M
    within = way.filter((pl.col("train") == "321M") & (front > FROM_M) & (front < TO_M + TRAIN_M))
    assert within.filter(pl.col("speed_mps") > LIMIT_MPS).is_empty()
    last = within.row(-1, named=True)
    assert last["estimate_error_m"] > 20.0  # it believes its rear to be beyond
    assert last["bound_behind_m"] > 60.0


@pytest.mark.nightly
def test_a_train_that_goes_by_where_it_believes_its_front_breaks_it(tmp_path: Path) -> None:
    assert run_with(None, BLIND, 9, tmp_path).broken == ()
    found = run_with("limits_end_at_the_estimate", BLIND, 9, tmp_path)
    assert [text.split(":")[0] for text in found.broken] == ["too-fast"]
