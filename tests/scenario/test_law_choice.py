import pytest

from network.errors import InputError
from network.files.toml_input import Record, validate
from onboard.driving_settings import Driving
from scenario.law_choice import laws_of

STOCK = ("K1", "K2")


class Table(Record):
    """The part of a scenario that chooses laws."""

    driving: Driving


def test_one_law_for_all_and_another_for_one() -> None:
    assert laws_of("s.toml", Driving(), STOCK) == {"K1": "hold_speed", "K2": "hold_speed"}
    driving = Driving(law="follow_plan", law_of={"K2": "hold_speed"}, notch_hold_s=3.0)
    assert laws_of("s.toml", driving, STOCK) == {"K1": "follow_plan", "K2": "hold_speed"}


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
        laws_of("s.toml", validate({"driving": table}, "s.toml", Table).driving, STOCK)
    assert refused.value.key == key
