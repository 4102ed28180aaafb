"""The page of sensors knows every sensor, reader and fault, and says what a default train carries."""

import pytest

from documents import sensors
from documents.sensors import document
from simulation.faults.table import KINDS
from simulation.sensors.table import SENSORS
from simulation.settings import PositionSensor, Sensors


def test_every_sensor_reader_and_word_of_a_file_has_its_place() -> None:
    text = document()
    assert {sensor.carried for sensor in SENSORS} - {None} == set(PositionSensor)
    assert all(f"## {sensor.page.title}" in text for sensor in SENSORS)
    files = {sensor.function.__module__.rpartition(".")[2] for sensor in SENSORS}
    of_sensors = [kind for kind in KINDS if kind.__module__.rpartition(".")[2] in files]
    assert of_sensors and all(f"`{kind.kind}`" in text for kind in of_sensors)
    assert f"The default is `{Sensors().carries[0]}`." in text


def test_a_reader_that_no_sensor_names_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sensors, "SENSORS", SENSORS[:-1])
    with pytest.raises(ValueError, match=SENSORS[-1].page.meant_by):
        document()


def test_errors_stand_with_their_origin() -> None:
    text = document()
    assert (
        "| `gnss.fail_safe` | sigma_m 1.2, noise_sigma_m 0.3, multipath_sigma_m 3, protection_m 20 |" in text
    )
    assert "Shift2Rail" in text
    assert '"version": 1' in text
