"""The table of faults and the words for links."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from simulation.faults.fault import Fault, Names
from simulation.faults.links import ANY, FaultyLink
from simulation.faults.table import FAULTS, KINDS

NAMES = Names(
    units=("K1",),
    devices=("block-manager", "B-W"),
    tags=("602",),
    points=("P7",),
    chargers=("KRS",),
    crossings=("C1",),
    sections=("OGN.1",),
    markers=("1",),
    cable=("A - B",),
)
PARTIES = st.sampled_from(["K1", "K2", "block-manager", "OGN-W", ANY])


def test_no_word_stands_for_two_faults() -> None:
    assert len(FAULTS) == len(KINDS)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.kind)
def test_a_fault_says_what_it_is_and_what_it_may_aim_at(kind: type[Fault[Any]]) -> None:
    assert kind.__doc__ and kind.__doc__ != Fault.__doc__
    assert kind.aims_at and kind.changes
    assert kind.targets(NAMES)
    bounded = {name for name, info in kind.model_fields.items() if name != "target" and info.description}
    assert bounded == set(kind.model_fields) - {"target"}


@given(PARTIES, PARTIES, st.booleans())
def test_a_link_is_read_as_it_is_written(source: str, destination: str, both_ways: bool) -> None:
    link = FaultyLink(source, destination, both_ways)
    assert FaultyLink.parse(str(link)) == link


@pytest.mark.parametrize(
    "words", ["K1", "", "K1 -> ", " -> K1", "K1->B-W", "K1 <-> B-W <-> K2", "K1 -> B-W <-> K1", 5]
)
def test_other_words_are_no_link(words: object) -> None:
    with pytest.raises(ValueError, match="a link such as"):
        FaultyLink.parse(words)


@pytest.mark.parametrize(
    ("words", "source", "destination", "joins"),
    [
        ("K1 -> B-W", "K1", "B-W", True),
        ("K1 -> B-W", "B-W", "K1", False),
        ("K1 <-> B-W", "B-W", "K1", True),
        ("K1 <-> B-W", "B-W", "K2", False),
        ("K1 <-> *", "B-E", "K1", True),
        ("K1 <-> *", "B-E", "K2", False),
        ("* -> B-W", "K2", "B-W", True),
        ("* -> B-W", "B-W", "K2", False),
        ("* <-> *", "K1", "B-W", True),
    ],
)
def test_which_telegrams_go_over_a_link(words: str, source: str, destination: str, joins: bool) -> None:
    assert FaultyLink.parse(words).joins(source, destination) is joins


def test_a_fault_out_of_its_bounds_cannot_be_made() -> None:
    for kind, values in (("scale", {"factor": 11.0}), ("loss", {"p": -0.1}), ("slow", {"factor": 0.5})):
        with pytest.raises(ValidationError):
            FAULTS[kind].model_validate({"target": "K1" if kind != "loss" else "* <-> *", **values})
