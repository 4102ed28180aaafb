"""Which driving law each stock has: `[driving] law` for all, `[driving.law_of]` by stock id."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from network.errors import InputError
from network.files.toml_input import one_of
from onboard.driving.laws.table import LAW_NAMES
from onboard.driving_settings import Driving
from simulation.setup import Setup


def laws_of(file: str, driving: Driving, stock_ids: Sequence[str]) -> dict[str, str]:
    """Name of the law of each stock. InputError for a law or a stock that there is not."""
    laws = dict.fromkeys(stock_ids, _named(file, "driving.law", driving.law))
    for stock_id, name in driving.law_of.items():
        key = f"driving.law_of.{stock_id}"
        if stock_id not in laws:
            raise InputError(file, key, stock_id, f"a stock id: {one_of(stock_ids, stock_id)}")
        laws[stock_id] = _named(file, key, name)
    return laws


def _named(file: str, key: str, name: str) -> str:
    if name not in LAW_NAMES:
        raise InputError(file, key, name, f"a driving law: {one_of(LAW_NAMES, name)}")
    return name


def driven_by(setup: Setup, law: str) -> Setup:
    """The same run with every stock driven by one law; its settings are those of the setup."""
    driving = setup.driving.model_copy(update={"law": law, "law_of": {}})
    return replace(setup, driving=driving, laws=dict.fromkeys(setup.trains, law))
