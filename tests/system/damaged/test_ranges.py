"""Every figure of every file at both ends of its range: just inside it is taken, just outside it is refused by name.

Each range can be switched off by name, and then the figures of that kind are found to be taken outside of it.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import pytest
from pydantic import BaseModel

from documents.files import FOLDER
from documents.ranges import MODELS, quantity_keys
from network.errors import InputError
from network.files.quantities import ALL, BY_NAME, MASS, SPEED
from network.files.quantity import Quantity
from network.files.toml_input import validate
from scenario.scenario_file import ScenarioFile
from simulation.faults.table import FAULTS
from study.outcome import Outcome
from tests.nightly import others_nightly
from tests.system.damaged.attempt import faults_of, told
from tests.system.damaged.bundles import RANGED, SCENARIO, text_of
from tests.system.damaged.damages import Case
from tests.system.damaged.places import Place, places_of, with_value
from vehicle import train_checks
from vehicle.train_file import TrainFile, train_of


def _places() -> dict[str, tuple[str, Place]]:
    """A figure for each key of each file, by a name for it: of a list the first."""
    found: dict[str, tuple[str, Place]] = {}
    for file, model in MODEL_OF.items():
        for place in places_of(model, DATA_OF[file]):  # type: ignore[type-var]
            keys = ".".join(str(part) for part in place.path if not isinstance(part, int))
            found.setdefault(f"{file} {keys}, {place.quantity.name}", (file, place))
    return found


MODEL_OF: Final = {file: model for bundle in RANGED for file, model in bundle.models.items()}
DATA_OF: Final = {file: bundle.files[file] for bundle in RANGED for file in bundle.models}
PLACES: Final = _places()
# One place of each quantity; every run tries every third. That a key has one is
# `test_every_number_of_every_file_has_a_kind`'s to say.
OF_EACH: Final = {place.quantity.name: name for name, (_, place) in reversed(PLACES.items())}


def _refusal(file: str, data: Mapping[str, Any]) -> InputError | None:
    """What the reader of that kind of file says of the data, without the other files."""
    model: type[BaseModel] = MODEL_OF[file]
    try:
        if model is TrainFile:
            train_of(data, file)
            return None
        entry = validate(data, file, model)
        if isinstance(entry, ScenarioFile):
            for table in entry.fault:
                own = {"target": table.target, **(table.model_extra or {})}
                validate(own, file, FAULTS[table.kind])
    except InputError as error:
        return error
    except ArithmeticError:  # what the range would have kept out has been reckoned with
        return None
    return None


def _wrong(file: str, place: Place) -> list[str]:
    """What the reader takes or refuses against the range of a place."""
    inside, outside = place.edges()
    wrong: list[str] = []
    for values, within in ((inside, True), (outside, False)):
        for value in values:
            error = _refusal(file, with_value(DATA_OF[file], place.path, value))
            blamed = error is not None and f"({place.quantity.name})" in error.expected
            if blamed is within:
                wrong.append(f"{file}: {place.key} = {value!r} {'refused' if within else 'taken'}: {error}")
    return wrong


@pytest.mark.parametrize("name", others_nightly(PLACES, set(list(OF_EACH.values())[::3])))
def test_the_ends_of_every_range(name: str) -> None:
    file, place = PLACES[name]
    inside, outside = place.edges()
    assert len(inside) >= 2
    assert outside
    assert _wrong(file, place) == []


@pytest.mark.parametrize("quantity", others_nightly(ALL, ALL[::8]), ids=lambda quantity: quantity.name)
def test_a_range_that_is_switched_off_is_noticed(quantity: Quantity, monkeypatch: pytest.MonkeyPatch) -> None:
    held = Quantity.holds
    monkeypatch.setattr(
        Quantity, "holds", lambda self, value: self.name == quantity.name or held(self, value)
    )
    mine = [(file, place) for file, place in PLACES.values() if place.quantity.name == quantity.name]
    assert mine
    assert all(_wrong(file, place) for file, place in mine)


@pytest.mark.parametrize(
    "quantity", others_nightly([MASS, SPEED], [MASS]), ids=lambda quantity: quantity.name
)
def test_a_range_that_is_switched_off_is_noticed_by_the_damaged_inputs(
    quantity: Quantity, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same through the command, as `test_damaged` tries it."""
    file, place = next((f, p) for f, p in PLACES.values() if p.quantity.name == quantity.name)
    files = dict(SCENARIO.written())
    files[file] = text_of(file, with_value(SCENARIO.files[file], place.path, place.edges()[1][0])).encode()
    case = Case(0, SCENARIO, file, quantity.name, {**files}, place)
    (tmp_path / "on").mkdir()
    assert faults_of(case, tmp_path / "on") == []
    (tmp_path / "off").mkdir()
    held = Quantity.holds
    monkeypatch.setattr(
        Quantity, "holds", lambda self, value: self.name == quantity.name or held(self, value)
    )
    assert faults_of(case, tmp_path / "off")


def test_every_number_of_every_file_has_a_kind() -> None:
    """No key has a range of its own, and none is without: factors of patches are judged by what comes of them."""
    without = {(model.__name__, key) for model in MODELS for key, name in quantity_keys(model) if not name}
    assert without == set()


def test_the_page_has_every_range_with_its_source() -> None:
    page = (FOLDER / "ranges.md").read_text("utf-8")
    for quantity in ALL:
        assert f"| {quantity.name} | {quantity.text()} | {quantity.source} |" in page
        assert quantity.source
    assert len(BY_NAME) == len(ALL)


# what two figures say together ------------------------------------------------------------------------------

TOGETHER: Final[dict[str, tuple[tuple[str | int, ...], object]]] = {
    "load over empty mass": (("body", "mass_load_full_t"), 900.0),
    "mass by length, full": (("body", "mass_empty_t"), 1000.0),
    "length by car": (("body", "cars"), 60),
    "acceleration of the full train from a stand on the level": (("traction", "curve_force_kn"), [0.5, 0.5, 0.5]),
    "greatest force at a start over the grip of the driven axles on dry rail, full": (
        ("traction", "force_max_kn"),
        100.0,
    ),
    "power over greatest force times greatest speed": (("traction", "power_max_kw"), 5.0),
    "running resistance at the greatest speed by weight": (("resistance", "air_n_per_kmh2"), 20.0),
    "strongest service notch over the grip of all axles on dry rail": (
        ("brakes", "notch_deceleration_kmhps"), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 9.0],
    ),
    "emergency brake over the grip of all axles on dry rail": (("emergency", "deceleration_mps2"), 3.0),
    "emergency brake over the strongest service notch": (("emergency", "deceleration_mps2"), 0.5),
    "greatest efficiency of motors, inverters and gears": (
        ("losses",), SCENARIO.files["v.toml"]["losses"] | dict.fromkeys(
            ("hysteresis_kw", "eddy_kw", "inverter_kw", "copper_kw", "gear_share"), 0.0
        ),
    ),
    "efficiency of motors, inverters and gears at the greatest force and base speed": (
        ("losses", "copper_kw"), 250.0,
    ),
    "no-load losses at base speed by greatest power": (("losses", "magnetising_kw"), 40.0),
    "base speed over greatest speed": (("losses", "base_speed_kmh"), 160.0),
}  # fmt: skip


def test_every_rule_has_a_train_that_breaks_it() -> None:
    assert set(TOGETHER) == {rule.name for rule in train_checks.RULES}


@pytest.mark.parametrize("name", others_nightly(TOGETHER, list(TOGETHER)[::3]))
def test_a_train_of_which_only_two_figures_show_that_it_is_none(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, value = TOGETHER[name]
    files = dict(SCENARIO.written())
    files["v.toml"] = text_of("v.toml", with_value(SCENARIO.files["v.toml"], path, value)).encode()
    for file, content in files.items():
        (tmp_path / file).write_bytes(content)
    code, _, err = told(("check", "s.toml"), tmp_path)
    assert code == Outcome.BAD_INPUT.code
    assert "v.toml: " in err and f"expected {name} " in err
    monkeypatch.setattr(train_checks, "RULES", [rule for rule in train_checks.RULES if rule.name != name])
    _, _, err = told(("check", "s.toml"), tmp_path)
    assert f"expected {name} " not in err
