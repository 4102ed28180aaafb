"""`[second_air]`: what it needs of a line, and faults of one network."""

from pathlib import Path

import pytest

from network.errors import InputError
from tests.scenario.own import own_scenario

BASE = "rtri_test_line"
REACHES = "[patch.line]\nadd.second_coverage = [{ from_km = 0.0, to_km = 0.5 }]\n"
ON_SECOND = '[[fault]]\nkind = "cut"\ntarget = "* <-> *"\nnetwork = "second"\nstart = "10:00:00"\n'


def test_a_second_network_reaches_where_the_line_says(tmp_path: Path) -> None:
    setup = own_scenario(tmp_path, f"[second_air]\n{REACHES}{ON_SECOND}", BASE).setup
    assert setup.networks == ("first", "second")
    (axis,) = setup.line.alignments.values()
    assert [[(c.from_m, c.to_m) for c in reach] for reach in axis.of_networks] == [
        [(0.0, 1410.0)],
        [(0.0, 500.0)],
    ]


def test_without_a_second_radio_it_does_not_reach(tmp_path: Path) -> None:
    setup = own_scenario(tmp_path, f"{REACHES}set.'alignments.main.coverage' = []\n", BASE).setup
    (axis,) = setup.line.alignments.values()
    assert (setup.networks, axis.coverage, axis.of_networks) == (("first",), (), ())


@pytest.mark.parametrize(
    ("text", "key"),
    [("[second_air]\n", "second_air"), (REACHES + ON_SECOND, "fault[0].network")],
    ids=["a network that reaches nowhere", "a fault of a network that trains do not have"],
)
def test_it_is_refused(tmp_path: Path, text: str, key: str) -> None:
    with pytest.raises(InputError) as raised:
        own_scenario(tmp_path, text, BASE)
    assert raised.value.key == key
