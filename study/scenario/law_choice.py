"""Which driving law each stock has: `[driving] law` for all, `[driving.law_of]` by stock id."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from network.errors import InputError
from network.files.toml_input import one_of
from onboard.driving.laws.table import LAW_NAMES

LAW: Final = "law"
LAW_OF: Final = "law_of"


def without_laws(tables: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """A scenario's tables whose `[driving]` holds nothing but figures, and what it says of laws."""
    driving = tables.get("driving")
    if not isinstance(driving, dict):
        return tables, {}
    figures = {key: value for key, value in driving.items() if key not in (LAW, LAW_OF)}
    return tables | {"driving": figures}, {key: driving[key] for key in (LAW, LAW_OF) if key in driving}


def laws_of(file: str, chosen: Mapping[str, Any], stock_ids: Sequence[str]) -> dict[str, str]:
    """Name of the law of each stock. InputError for a law or a stock that there is not."""
    everywhere = _named(file, f"driving.{LAW}", chosen.get(LAW, LAW_NAMES[0]))
    laws = dict.fromkeys(stock_ids, everywhere)
    own = chosen.get(LAW_OF, {})
    if not isinstance(own, dict):
        raise InputError(file, f"driving.{LAW_OF}", own, "a table: stock id = law")
    for stock_id, name in own.items():
        if stock_id not in laws:
            expected = f"a stock id: {one_of(stock_ids, stock_id)}"
            raise InputError(file, f"driving.{LAW_OF}.{stock_id}", stock_id, expected)
        laws[stock_id] = _named(file, f"driving.{LAW_OF}.{stock_id}", name)
    return laws


def _named(file: str, key: str, name: object) -> str:
    if not isinstance(name, str) or name not in LAW_NAMES:
        raise InputError(file, key, name, f"a driving law: {one_of(LAW_NAMES, str(name))}")
    return name
