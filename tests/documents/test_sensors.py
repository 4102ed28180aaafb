"""The page of sensors knows every sensor, reader and fault, and says what a default train carries."""

from __future__ import annotations

import pytest

from documents import sensors
from documents.sensors import PAGES, document
from onboard.localisation.table import READERS
from simulation.faults.table import KINDS
from simulation.sensors.table import SENSORS
from simulation.settings import Carried, Sensors


def test_every_sensor_reader_and_word_of_a_file_has_its_place() -> None:
    text = document()
    assert set(PAGES) == {sensor.name for sensor in SENSORS}
    assert {page.reader for page in PAGES.values()} == {"", *(reader.name for reader in READERS)}
    assert {page.carried for page in PAGES.values()} - {None} == set(Carried)
    assert all(f"## {page.title}" in text for page in PAGES.values())
    modules = {sensor.function.__module__ for sensor in SENSORS}
    assert all(f"`{kind.kind}`" in text for kind in KINDS if kind.__module__ in modules)
    assert f"A default train carries: `{Sensors().carries[0]}`." in text


def test_a_sensor_without_a_page_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sensors, "SENSORS", SENSORS[1:])
    with pytest.raises(ValueError, match=SENSORS[0].name):
        document()


def test_errors_stand_with_their_origin() -> None:
    text = document()
    assert (
        "| `gnss.fail_safe` | sigma_m 1.2, noise_sigma_m 0.3, multipath_sigma_m 3, protection_m 20 |" in text
    )
    assert "Shift2Rail" in text
    assert '"version": 1' in text
