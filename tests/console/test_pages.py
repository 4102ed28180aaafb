"""What the desk's pages say stands in the catalogue, which has nothing that they do not say."""

import re
from importlib.resources import files

from console.line_seen import ALARMS
from console.protocol import RoadState, SectionState, StepState, schema
from console.seats import RIGHTS, Seat
from simulation.faults.script import ActKind
from study.wording.catalogue import phrases_of
from study.wording.events import EVENT_WORDINGS

# What comes from a table, and not from a text of the module that says it.
BY_VALUE = {
    *(state.value for state in SectionState),
    *(seat.value for seat in Seat if seat is not Seat.GUEST),
    *("unit", "party", "points", "position", "place", "sections", "hold", "pace", "person", "crossing"),
    *("behind", "over", "track", "train", "notch", "confirm_stabled", "role", "step", "block"),
    *(state.value for state in (*StepState, *RoadState)),
}


def pages() -> str:
    folder = files("console") / "web"
    return "".join(item.read_text("utf-8") for item in folder.iterdir() if item.name.endswith(".js"))


def test_the_catalogue_has_what_the_pages_say_and_nothing_is_left_over() -> None:
    text = pages()
    said = set(re.findall(r'\bsay\("([^"]+)"', text)) | BY_VALUE
    heads = re.search(r"const heads = \[(.*?)\];", text)
    assert heads is not None
    said |= set(re.findall(r'"([^"]+)"', heads[1]))
    said |= {"runs", "stands"}
    assert said == set(phrases_of("desk"))


def test_nothing_is_loaded_from_elsewhere_and_japanese_stands_in_the_catalogue() -> None:
    text = pages() + (files("console") / "web" / "index.html").read_text("utf-8")
    assert set(re.findall(r"https?://[^\"'`\s]+", text)) == {"http://www.w3.org/2000/svg"}
    assert re.findall("[ぁ-んァ-ヶ一-龠]+", text) == ["日本語"]


def test_every_act_is_some_seats_and_has_its_fields_on_the_page() -> None:
    table = re.search(r"const ACT_FIELDS = \{(.*?)\};", pages(), re.DOTALL)
    assert table is not None
    kinds = {kind.value for kind in ActKind}
    assert set(re.findall(r"(\w+): \[", table[1])) == kinds
    assert {act.value for seat in Seat if seat is not Seat.INSTRUCTOR for act in RIGHTS[seat].acts} == kinds


def test_every_alarm_has_words_or_nobody_would_hear_it() -> None:
    assert set(ALARMS) - set(EVENT_WORDINGS) == set()


def test_the_schema_knows_every_message_by_its_word() -> None:
    words = {
        part["properties"]["say"]["enum"][0]
        for part in schema()["$defs"].values()
        if "say" in part.get("properties", {})
    }
    assert {"hello", "welcome", "state", "answer", "fail", "act", "go_back", "save"} <= words
