"""A short line to work, and a desk without a thread."""

import asyncio
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import pytest

from scenario.scenario import Scenario, load_scenario

T = TypeVar("T")
TWO = 'extends = "rtri_test_line"\nid = "two"\nname = "two"\ntimetable = "rtri_two_trains"\n'


@pytest.fixture(scope="session")
def two_trains(tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    """Two trains on the test line, with staff who react."""
    file = tmp_path_factory.mktemp("two") / "two.toml"
    file.write_text(f"{TWO}[people]\nreact = true\n", "utf-8")
    return load_scenario(str(file))


def run_apart(coroutine: Coroutine[Any, Any, T]) -> T:
    """Run it in a thread of its own: another test of this process may have left a loop running in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, coroutine).result()
