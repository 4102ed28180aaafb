"""The recipe "a column" of docs/make-a.md, followed: a field and its value, and table, totals and headings have it."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest

READ = """
import json
from study.compare.measures import TABLES, columns_in
from study.measures.driving import driving_sums
from study.record.driving import DrivenHop
from study.record.figure import figures_of, schema_of
from tests.study.measures.test_driving import hops
print(json.dumps({
    "column": list(schema_of(DrivenHop))[-1],
    "heading": figures_of(DrivenHop)["mean_kmh"].heading.en,
    "hops": [hop.mean_kmh for hop in hops()],
    "together": driving_sums(hops())["mean_kmh"],
}))
"""


def test_a_field_and_its_value_make_a_column_with_its_totals_and_words(clone: Callable[[], Any]) -> None:
    made = clone()
    made.follow("column")
    assert made.is_what_is_told("column")
    assert len(made.touched) == 2
    made.holds("tests/study/measures/test_driving.py", "tests/study/record/test_tables.py")
    done = made.python("-c", READ)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert (found["column"], found["heading"]) == ("mean_kmh", "mean speed, km/h")
    # by hand: 1000 m in 100 s, 1500 m in 200 s, 1000 m in 100 s; together weighed by the time
    assert found["hops"] == pytest.approx([36.0, 27.0, 36.0])
    assert found["together"] == pytest.approx(3.6 * 3500.0 / 400.0)
