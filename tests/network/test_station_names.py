"""Stations by id, name or Japanese name."""

from dataclasses import replace

import pytest

from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.station_names import station_id_of


@pytest.mark.parametrize("said", ["OGN", "ogn", "Ogane", "OGANE", "大金"])
def test_a_station_is_found_by_what_people_call_it(said: str) -> None:
    assert station_id_of(load_line(shipped_line("karasuyama")), said) == "OGN"


def test_a_name_of_none_or_of_two_is_refused_with_what_there_is() -> None:
    line = load_line(shipped_line("karasuyama"))
    with pytest.raises(InputError, match=r"--station is 'Ogana'; expected one of .*OGN"):
        station_id_of(line, "Ogana")
    twin = replace(line.stations["HSK"], name="Ogane")
    with pytest.raises(InputError, match="expected one of HSK, OGN"):
        station_id_of(replace(line, stations={**line.stations, "HSK": twin}), "Ogane")
