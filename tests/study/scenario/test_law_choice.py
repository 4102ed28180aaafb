from __future__ import annotations

import pytest

from network.errors import InputError
from study.scenario.law_choice import laws_of, without_laws

STOCK = ("K1", "K2")


def test_one_law_for_all_and_another_for_one() -> None:
    assert laws_of("s.toml", {}, STOCK) == {"K1": "hold_speed", "K2": "hold_speed"}
    driving = {"law": "follow_plan", "law_of": {"K2": "hold_speed"}, "notch_hold_s": 3.0}
    tables, chosen = without_laws({"id": "s", "driving": driving})
    assert tables == {"id": "s", "driving": {"notch_hold_s": 3.0}}
    assert laws_of("s.toml", chosen, STOCK) == {"K1": "follow_plan", "K2": "hold_speed"}


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ({"law": "full_speed"}, "driving.law"),
        ({"law": 3.0}, "driving.law"),
        ({"law_of": {"K9": "hold_speed"}}, "driving.law_of.K9"),
        ({"law_of": {"K1": "hold_sped"}}, "driving.law_of.K1"),
        ({"law_of": "hold_speed"}, "driving.law_of"),
    ],
)
def test_what_there_is_not_is_refused_by_its_key(table: dict[str, object], key: str) -> None:
    with pytest.raises(InputError) as refused:
        laws_of("s.toml", table, STOCK)
    assert refused.value.key == key
