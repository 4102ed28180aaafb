import gc
import re
from pathlib import Path
from typing import Annotated, Final, Protocol

import numpy as np
import pytest
from mypy import api

from network.files.kinds import about
from network.files.quantities import Gain
from network.files.toml_input import Record
from onboard.records import UnitRow
from simulation.world.records import STOCK
from vehicle.compiled import compiled
from vehicle.record import cells_of, dtype_of, fields_of, put_settings, unit_of

STEPS: Final = 3


class AxleRow(Protocol):
    speed_mps: Annotated[float, "of the tread"]
    sliding: int


class WheelRow(Protocol):
    pulses: Annotated[list[int], STEPS, "of the last steps"]
    axle: AxleRow
    worn_m: float


WHEEL: Final = dtype_of(WheelRow)


@compiled
def turn(wheel: WheelRow) -> float:
    axle = wheel.axle
    axle.speed_mps += 2.0
    wheel.pulses[1] += 5
    return axle.speed_mps + wheel.worn_m


def test_a_record_is_laid_out_as_its_class_says() -> None:
    assert WHEEL.names == ("pulses", "axle", "worn_m")
    assert (WHEEL["pulses"].base, WHEEL["pulses"].shape) == (np.dtype("i8"), (STEPS,))
    assert WHEEL["axle"] == np.dtype([("speed_mps", "f8"), ("sliding", "i8")], align=True)
    assert WHEEL["worn_m"] == np.dtype("f8")
    assert WHEEL.isalignedstruct


def test_compiled_code_reads_and_writes_a_record_in_a_record() -> None:
    wheels = np.zeros(2, dtype=WHEEL).view(np.recarray)
    wheels["worn_m"] = 0.5
    assert [turn(wheels[1]), turn(wheels[1])] == [2.5, 4.5]
    assert wheels["axle"]["speed_mps"].tolist() == [0.0, 4.0]
    assert wheels["pulses"].tolist() == [[0, 0, 0], [0, 10, 0]]


def test_a_record_documents_itself() -> None:
    pulses, axle, worn = fields_of(WheelRow)
    assert (pulses.name, pulses.kind, pulses.length, pulses.meaning) == (
        "pulses",
        int,
        3,
        "of the last steps",
    )
    assert (axle.kind, worn.unit) == (AxleRow, "m")


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("speed_mps", "m/s"),
        ("gain_per_s", "1/s"),
        ("trailer_linear_n_per_kn_kmh", "N/(kN km/h)"),
        ("adhesion_speed_factor_s_per_m", "s/m"),
        ("sliding", ""),
        ("m", ""),  # a name is not its own unit
    ],
)
def test_the_unit_is_the_longest_that_ends_the_name(name: str, unit: str) -> None:
    assert unit_of(name) == unit


class NoSize(Protocol):
    pulses: list[int]


class Text(Protocol):
    name: str


class SizedScalar(Protocol):
    speed_mps: Annotated[float, 3]


class Empty(Protocol):
    pass


@pytest.mark.parametrize(
    ("row", "names"),
    [(NoSize, "NoSize.pulses"), (Text, "Text"), (SizedScalar, "SizedScalar.speed_mps"), (Empty, "Empty")],
)
def test_what_no_record_can_hold_is_refused_by_name(row: type, names: str) -> None:
    with pytest.raises(TypeError, match=re.escape(names)):
        dtype_of(row)


@pytest.mark.nightly
def test_a_field_misspelt_in_a_law_is_an_error_of_the_type_checker(tmp_path: Path) -> None:
    law = tmp_path / "law.py"
    body = "def {name}(plant: PlantRow) -> float:\n    return plant.{field}\n"
    laws = [body.format(name=field, field=field) for field in ("speed_mps", "sped_mps")]
    law.write_text("\n\n".join(("from vehicle.records import PlantRow\n", *laws)))
    said, _, status = api.run(["--strict", str(law)])
    assert status == 1
    assert '"PlantRow" has no attribute "sped_mps"' in said
    assert {line.split(":")[1] for line in said.splitlines() if ": error: " in line} == {"9"}


def test_cells_are_the_memory_of_the_record_with_plain_numbers() -> None:
    """Every field of the project's largest record, set from either side, is the same on the other."""
    stock = np.zeros(2, dtype=STOCK)
    part = stock["board"]["unit"]
    record = part.view(np.recarray)[1]
    cells = cells_of(UnitRow, record)
    for number, field in enumerate(fields_of(UnitRow), 1):
        setattr(cells, field.name, field.kind(number))
        assert part[field.name][1] == number
        part[field.name][1] = number + 1
        assert getattr(cells, field.name) == number + 1
        assert type(getattr(cells, field.name)) is field.kind
    assert not part[0].tobytes().strip(b"\0")  # and no other's


def test_cells_keep_the_memory_that_they_look_at() -> None:
    cells = cells_of(UnitRow, np.zeros(1, dtype=dtype_of(UnitRow)).view(np.recarray)[0])
    gc.collect(0)
    cells.position_m = 7.0
    assert cells.position_m == 7.0


class Habits(Record):
    """Numbers, a switch, and a word that no record holds."""

    gain_per_s: Annotated[Gain, about("what it does")] = 1.5
    times: int = 2
    on: bool = True
    word: str = "some"


class HabitsRow(Protocol):
    settings: Habits
    error_mps: float


def test_a_table_of_a_file_is_a_record_of_its_numbers_and_switches() -> None:
    row = np.zeros(1, dtype=dtype_of(HabitsRow)).view(np.recarray)[0]
    assert row.dtype["settings"].names == ("gain_per_s", "times", "on")
    assert fields_of(Habits)[0].meaning == "what it does"
    put_settings(row.settings, Habits(gain_per_s=0.5, on=False))
    assert row.settings.tolist() == (0.5, 2, 0)
    assert row.error_mps == 0.0
