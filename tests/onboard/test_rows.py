from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from onboard.records import BEHAVIOUR, PATTERN, UNIT
from onboard.rows import BehaviourRow, PathRow, UnitRow
from simulation.records import TRUTH
from simulation.rows import TruthRow


@pytest.mark.parametrize(
    ("record", "row"), [(UNIT, UnitRow), (PATTERN, PathRow), (BEHAVIOUR, BehaviourRow), (TRUTH, TruthRow)]
)
def test_a_row_type_names_the_fields_of_its_record_in_order_and_kind(record: np.dtype, row: type) -> None:
    kinds = {"f": "float", "i": "int"}
    fields: Mapping[Any, Any] = record.fields or {}
    assert row.__annotations__ == {name: kinds[fields[name][0].kind] for name in record.names or ()}
