"""Long tables of cases and costly examples: some in every run, the others in `make nightly`."""

from collections.abc import Collection, Iterable, Mapping
from typing import Any

import pytest
from hypothesis import settings

A_FIFTH = settings(max_examples=settings().max_examples // 5)  # of the profile's examples: each is a run


def others_nightly(
    cases: Iterable[Any] | Mapping[str, Any], every_run: Collection[Any], *, columns: bool = False
) -> list[Any]:
    """All cases for `parametrize`; those not named as of every run are marked. A name of no case is an error.

    `columns`: each case is a row of values of several parameters.
    """
    rows = list(cases)
    unknown = [name for name in every_run if name not in rows]
    if unknown:
        raise ValueError(f"no such cases: {unknown}")
    return [
        row if row in every_run else pytest.param(*(row if columns else (row,)), marks=pytest.mark.nightly)
        for row in rows
    ]
