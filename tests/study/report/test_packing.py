"""What is packed into the page comes back, to its precision."""

import math

from hypothesis import given
from hypothesis import strategies as st

from study.report.packing import deflated, packed_column, places_in, unpacked
from tests.study.report.page import inflated

values_of_columns = st.lists(st.none() | st.floats(-1e6, 1e6) | st.just(math.nan) | st.just(math.inf))
texts = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**50), 2**50) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=12,
)


@given(values=values_of_columns, per_unit=st.sampled_from([1, 10, 1000]))
def test_a_column_comes_back_to_half_a_step(values: list[float | None], per_unit: int) -> None:
    column = packed_column(values, per_unit)
    assert all(step is None or isinstance(step, int) for step in column["d"])
    back = unpacked(column)
    assert len(back) == len(values)
    for value, again in zip(values, back, strict=True):
        if value is None or not math.isfinite(value):
            assert again is None
        else:
            assert again is not None
            assert abs(again - value) <= 0.5 / per_unit + 1e-9 * abs(value)


@given(payload=st.dictionaries(st.text(), texts))
def test_a_payload_comes_back_and_holds_no_markup(payload: dict[str, object]) -> None:
    text = deflated(payload)
    assert not set("<>&\"' ") & set(text)
    assert inflated(text) == payload
    assert deflated(payload) == text


def test_places_are_in_order_of_appearance() -> None:
    assert places_in(["b", "a", None, "b"]) == (["b", "a"], [0, 1, None, 0])
