"""Train rows for the tests of the vehicle package; read-only, copy before changing."""

from collections.abc import Callable

import numpy as np
import pytest

from tests.rows import Rows
from vehicle.train_file import load_train, shipped_train


@pytest.fixture(scope="session")
def ev_e301() -> Rows:
    return load_train(shipped_train("ev_e301")).row


@pytest.fixture(scope="session")
def oda() -> Rows:
    return load_train(shipped_train("oda_train")).row


@pytest.fixture(scope="session")
def hitachi() -> Rows:
    return load_train(shipped_train("hitachi_train")).row


@pytest.fixture(scope="session")
def br642() -> Rows:
    return load_train(shipped_train("br642")).row


@pytest.fixture(scope="session")
def changed() -> Callable[..., Rows]:
    """A copy of a row with some fields set; `free=True` removes all running resistance first."""

    def change(row: Rows, free: bool = False, **fields: float) -> Rows:
        copy = np.array(row)
        if free:
            copy["resistance"] = 0.0
        for name, value in fields.items():
            copy[name] = value
        return copy

    return change
