"""`[[chargers]]`: at tracks that are there, one a station; what it gives is the least of its limits."""

import pytest

from network.errors import InputError
from network.files.line_file import line_of, parse_line
from network.files.line_schema import LineFile
from network.files.shipped import shipped_line
from network.files.toml_input import parse_toml
from network.model import Line
from network.patching.track_removal import without_track

TEXT = shipped_line("karasuyama").read_text("utf-8")


def with_charger(more: str) -> Line:
    origin = 'origin = "assumed: for a test"'
    return parse_line(
        f"{TEXT}\n[[chargers]]\n{more}\npower_kw = 100.0\nvoltage_v = 1500.0\n{origin}\n", "l.toml"
    )


def test_all_tracks_where_none_is_named_and_the_least_of_its_limits() -> None:
    charger = with_charger('station = "OGN"\ncurrent_max_a = 50.0').chargers["OGN"]
    assert charger.tracks == ("1", "2")
    assert charger.power_w == 75e3


@pytest.mark.parametrize(
    ("more", "key", "said"),
    [
        ('station = "OGN"\ntracks = ["7"]', "chargers[2].tracks[0]", "a track of OGN"),
        ('station = "ONG"', "chargers[2].station", "OGN"),
        ('station = "KRS"', "chargers[2].station", "one charger a station"),
    ],
)
def test_one_that_cannot_be_is_refused(more: str, key: str, said: str) -> None:
    with pytest.raises(InputError) as error:
        with_charger(more)
    assert error.value.key == key and said in str(error.value)


def test_a_track_taken_out_takes_its_charger_along() -> None:
    more = 'station = "OGN"\ntracks = ["2"]\npower_kw = 1.0\nvoltage_v = 750.0\norigin = "assumed: a test"'
    entry = parse_toml(f"{TEXT}\n[[chargers]]\n{more}\n", "l.toml", LineFile)
    left = line_of(without_track(entry, "OGN.2", "l.toml", "remove_tracks"), "l.toml")
    assert sorted(left.chargers) == ["HSK", "KRS"]
