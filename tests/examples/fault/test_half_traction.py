"""The fault of docs/make-a.md in this process: a class, what puts it into the world, a drill that uses it."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any, cast

import pytest

from network.errors import InputError
from simulation.faults.table import FAULTS
from simulation.world import disorder
from study.drilling.drill import Drill, run_drill
from study.runner.run import PartyLink
from tests.examples.conftest import ENTRY, recipe

HERE = Path(__file__).parent
DRILL = str(HERE / "half_traction.toml")


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    spec = importlib.util.spec_from_file_location("simulation.faults.traction", HERE / "traction.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def listed(example: ModuleType, monkeypatch: pytest.MonkeyPatch) -> type[Any]:
    """The fault in the table, and what the recipe puts into the world for it."""
    kind: type[Any] = example.WeakTraction
    for _, _, _, text in ENTRY.findall(recipe("fault")):
        exec(text, dict(vars(disorder)))
    monkeypatch.setitem(cast("dict[str, Any]", FAULTS), kind.kind, kind)
    return kind


def arrival_s(drill: Drill) -> float:
    return float(drill.run.tables.stops.filter(train="T1", station="B")["arrival_s"][0])


def test_without_its_file_the_table_does_not_know_it() -> None:
    with pytest.raises(InputError, match="weak_traction"):
        run_drill(DRILL, PartyLink.SIMULATED)


def test_with_half_the_force_a_train_accelerates_half_as_fast_and_arrives_later(
    listed: type[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    weak = run_drill(DRILL, PartyLink.SIMULATED)
    assert weak.passed
    monkeypatch.setattr(listed, "applied_to", lambda _self, share: share)
    whole = run_drill(DRILL, PartyLink.SIMULATED)
    assert arrival_s(weak) > arrival_s(whole) + 1.0

    def fastest(drill: Drill) -> float:
        """Strongest acceleration of the train's first minute, m/s^2."""
        rows = drill.run.tables.trajectory.filter(train="T1")
        return float(
            cast("float", rows.filter(rows["t_s"] < rows["t_s"][0] + 60.0)["acceleration_mps2"].max())
        )

    assert 0.4 < fastest(weak) / fastest(whole) < 0.55  # half the force less the same resistance
