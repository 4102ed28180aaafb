"""Events in scenario files are held against the types of events: a misspelt one is bad input, never "met"."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from network.errors import InputError
from scenario import event_file
from scenario.event_file import matcher_in
from simulation.events import EVENTS, Author, authors_of
from simulation.faults.fault import Names
from simulation.faults.script import Matcher

NAMES = Names(
    units=("K1", "K2"),
    devices=("block-manager", "B-W"),
    tags=("601",),
    points=("P7",),
    sections=("5", "6"),
    stations=("A",),
    trains=("T1",),
    people=("controller", "staff"),
    routes=("A.1>B.1",),
    pieces=("5", "P7.stem"),
)
HEAD = 'extends = "rtri_test_line"\nid = "tried"\n'

# what is wrong: the event, the key at fault, and what the message must offer
WRONG: dict[str, tuple[dict[str, Any], str, str]] = {
    "a field misspelt": ({"what": "granted", "unt": "K1"}, "e.unt", "unit"),
    "an event misspelt": ({"what": "grantd"}, "e.what", "granted"),
    "a field of another event": ({"what": "moving", "points": "P7"}, "e.points", ""),
    "a word for a number": ({"what": "intervention", "level": "2"}, "e.level", "int"),
    "true for a number": ({"what": "intervention", "level": True}, "e.level", "int"),
    "a level there is not": ({"what": "intervention", "level": 3}, "e.level", "0, 1, 2"),
    "a number for a word": ({"what": "departs", "station": 7}, "e.station", "str"),
    "a train as a number": ({"what": "mission", "train": 1}, "e.train", "str"),
    "a word that no enum has": ({"what": "proven", "position": "norml"}, "e.position", "normal, reverse"),
    "an enum's word of another case": ({"what": "points_locked", "position": "NORMAL"}, "e.position", "normal"),
    "a purpose misspelt": ({"what": "tag_read", "purpose": "arival"}, "e.purpose", "arrival"),
    "a place of loss misspelt": ({"what": "lost", "where": "air"}, "e.where", "the air"),
    "a kind of telegram misspelt": ({"what": "took_effect", "kind": "RouteGrant"}, "e.kind", "RouteGranted"),
    "a reason misspelt": ({"what": "telegram_dropped", "why": "repeatd"}, "e.why", "repeated"),
    "a fault misspelt": ({"what": "fault", "kind": "powr_off"}, "e.kind", "power_off"),
    "a fault of what it cannot hit": ({"what": "fault", "kind": "stuck", "target": "K1"}, "e.target", "P7"),
    "an act misspelt": ({"what": "act", "act": "giveback"}, "e.act", "give_back"),
    "a stage misspelt": ({"what": "picture", "stage": "define"}, "e.stage", "defined"),
    "a standing misspelt": ({"what": "accepted", "was": "unknwn"}, "e.was", "unknown"),
    "a tag as text": ({"what": "tag_read", "tag": "601"}, "e.tag", "int"),
    "a tag there is not": ({"what": "tag_read", "tag": 9}, "e.tag", "601"),
    "points there are not": ({"what": "proven", "points": "P8"}, "e.points", "P7"),
    "a section in a list": ({"what": "freed", "sections": ["5", "9"]}, "e.sections", "5, 6"),
    "a list in a list": ({"what": "freed", "sections": [["5"]]}, "e.sections", "str"),
    "a route there is not": ({"what": "route_held", "route": "A.1>C"}, "e.route", "A.1>B.1"),
    "a unit there is not": ({"what": "granted", "unit": "K9"}, "e.unit", "K1, K2"),
    "a device there is not": ({"what": "power_off", "device": "B-E"}, "e.device", "B-W"),
    "a train there is not": ({"what": "departs", "of_train": "T9"}, "e.of_train", "T1"),
    "an author who never writes it": ({"who": "world", "what": "granted"}, "e.who", "block manager"),
    "a device that is no manager": ({"who": "B-W", "what": "granted"}, "e.who", "block manager"),
    "an author as a number": ({"who": 1, "what": "granted"}, "e.who", "text"),
    "no number": ({"what": "overran", "beyond_m": float("nan")}, "e.beyond_m", "finite"),
    "no event": ({"who": "K1"}, "e.what", ""),
}  # fmt: skip


@pytest.mark.parametrize("exact", [True, False])
@pytest.mark.parametrize("name", WRONG)
def test_what_no_journal_can_have_is_refused(name: str, exact: bool) -> None:
    given, key, offered = WRONG[name]
    with pytest.raises(InputError) as error:
        matcher_in("f.toml", "e", given, NAMES, exact=exact)
    assert error.value.key == key
    assert offered in error.value.expected
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize(
    "given",
    [
        {"what": "position_fault", "why": "expected tag was not read"},
        {"what": "arrived", "station": "A", "error_m": 0.25},
        {"what": "fault", "kind": "slow", "parameters": {"factor": 2.0}},
    ],
)
def test_what_cannot_be_checked_may_not_stand_where_nothing_would_notice(given: dict[str, Any]) -> None:
    """A sentence or a measured figure: refused of what must be absent and of what begins a fault or an act."""
    assert isinstance(matcher_in("f", "e", given, NAMES), Matcher)
    with pytest.raises(InputError, match="never be noticed"):
        matcher_in("f", "e", given, NAMES, exact=True)


@pytest.mark.parametrize(
    "given",
    [
        {"who": "K1", "what": "proven", "points": "P7", "position": "normal", "by_crew": False},
        {"who": "block-manager", "what": "granted", "unit": "K1", "sections": "5"},
        {"who": "block-manager", "what": "granted", "unit": "K1", "sections": ["5", "6"]},
        {"who": "world", "what": "fault", "kind": "cut", "target": "K1 <-> block-manager"},
        {"who": "staff", "what": "points_set_by_hand", "points": "P7"},
        {"who": "controller", "what": "act", "act": "reenter_assisted"},
        {"who": "B-W", "what": "points_unproven", "points": "P7", "unit": "K1"},
        {"what": "tag_read", "tag": 601, "purpose": "approach"},
        {"what": "intervention", "level": 2, "of_train": "T1"},
        "train T1 passes tag 601",
        "train T1 holds 5",
        "block-manager restarts",
    ],
)
def test_what_a_journal_can_have_is_taken(given: str | dict[str, Any]) -> None:
    assert matcher_in("f", "e", given, NAMES, exact=True).events


def test_every_field_of_every_event_is_checked_by_type() -> None:
    """A table where a value is due is wrong for all but the one field that is a table."""
    for what, event in EVENTS.items():
        for field in msgspec.structs.fields(event):
            if field.name == "parameters":
                continue
            with pytest.raises(InputError) as error:
                matcher_in("f", "e", {"what": what, field.encode_name: {"x": 1}}, NAMES)
            assert error.value.key == f"e.{field.encode_name}"


def test_every_event_has_an_author_among_the_parties() -> None:
    who = {
        Author.UNIT: "K1",
        Author.MANAGER: "block-manager",
        Author.TERMINAL: "B-W",
        Author.WORLD: "world",
        Author.PERSON: "staff",
    }
    for what, event in EVENTS.items():
        for author, name in who.items():
            given = {"who": name, "what": what}
            if author in authors_of(event):
                assert matcher_in("f", "e", given, NAMES).who == name
            else:
                with pytest.raises(InputError, match="who writes"):
                    matcher_in("f", "e", given, NAMES)


PLACES = {
    "event": '[[expect]]\ntext = "t"\nabsent = true\nevent = {}\n',
    "a present event": '[[expect]]\ntext = "t"\nevent = {}\n',
    "after": '[[expect]]\ntext = "t"\nevent = "K1 restarts"\nabsent = true\nafter = {}\n',
    "until": '[[expect]]\ntext = "t"\nevent = "K1 restarts"\nabsent = true\nuntil = {}\n',
    "start of a fault": '[[fault]]\nkind = "restart"\ntarget = "K1"\nstart = {}\n',
    "start of an act": '[[act]]\nkind = "give_back"\ntarget = "K1"\nstart = {}\n',
}
DRILL = '[[fault]]\nkind = "restart"\ntarget = "B-W"\nstart = "10:00"\n'


@pytest.mark.parametrize("place", PLACES)
def test_a_misspelt_event_ends_the_drill_with_2_wherever_it_stands(
    main: Callable[..., Any], tmp_path: Path, place: str
) -> None:
    script = PLACES[place].format('{ who = "K1", what = "proven", position = "norml" }')
    (tmp_path / "tried.toml").write_text(HEAD + DRILL + script, "utf-8")
    ended = main("drill", "tried.toml")
    assert ended.code == 2, ended
    assert "position is 'norml'" in ended.err and "normal, reverse" in ended.err
    assert ended.out == ""


def test_without_the_check_a_misspelt_word_counts_as_met(
    main: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The defect that the check guards against, shown with the check switched off."""
    for name in ("_check_type", "_check_known", "_check_author"):
        monkeypatch.setattr(event_file, name, lambda *_: True)
    script = PLACES["event"].format('{ who = "K1", what = "proven", position = "norml" }')
    (tmp_path / "tried.toml").write_text(HEAD + DRILL + script, "utf-8")
    ended = main("drill", "tried.toml")
    assert ended.code == 0, ended
    assert "met      t: did not happen" in ended.out


@pytest.mark.parametrize(
    ("place", "takes"), [("until", "until is '12:90'; expected words"), ("start of an act", "HH:MM")]
)
def test_a_time_is_asked_for_where_one_may_stand(
    main: Callable[..., Any], tmp_path: Path, place: str, takes: str
) -> None:
    (tmp_path / "tried.toml").write_text(HEAD + DRILL + PLACES[place].format('"12:90"'), "utf-8")
    assert takes in main("check", "tried.toml").err
