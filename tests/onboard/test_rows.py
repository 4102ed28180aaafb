from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from onboard.records import BEHAVIOUR, PATTERN, UNIT
from onboard.rows import BehaviourRow, PathRow, UnitRow
from simulation.world.records import TRUTH
from simulation.world.rows import TruthRow


@pytest.mark.parametrize(
    ("record", "row"), [(UNIT, UnitRow), (PATTERN, PathRow), (BEHAVIOUR, BehaviourRow), (TRUTH, TruthRow)]
)
def test_a_row_type_names_the_fields_of_its_record_in_order_and_kind(record: np.dtype, row: type) -> None:
    kinds = {"f": "float", "i": "int"}
    fields: dict[str, Any] = {str(name): field for name, field in (record.fields or {}).items()}
    assert row.__annotations__ == {name: kinds[fields[name][0].kind] for name in record.names or ()}
