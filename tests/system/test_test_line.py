"""The paper's run from section 3 to section 8 (Sugiyama et al. 2017, sections 2.2 and 5) in its journal."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

Entry = dict[str, Any]
THROW_S = 6.0  # as the line file has it


@pytest.fixture(scope="module")
def journal(main_in: Callable[..., Any], tmp_path_factory: pytest.TempPathFactory) -> list[Entry]:
    ended = main_in("run", "rtri_test_line", "--json", cwd=tmp_path_factory.mktemp("run"))
    assert ended.code == 0, ended.err
    figures = ended.figures()
    assert (figures["trains_arrived"], figures["invariants_broken"]) == (1, 0)
    assert figures["early_departure_s_max"] == 0.0
    assert figures["late_s_max"] <= 60.0
    assert figures["stop_error_m_max_abs"] <= 1.0
    text = (Path(figures["out"]) / "journal.jsonl").read_text("utf-8")
    return [json.loads(line) for line in text.splitlines()]


def found(entries: Iterator[Entry], who: str, what: str, **data: object) -> Entry:
    """The next entry of this kind, after all that were found before."""
    wanted = {"who": who, "what": what, **data}
    for entry in entries:
        if all(entry.get(key) == value for key, value in wanted.items()):
            return entry
    raise AssertionError(f"no {wanted} after what came before")


def throw(entries: Iterator[Entry], points: str, terminal: str, section: str) -> tuple[float, float]:
    """A real throw: commanded, unlocked, moved, locked, proven; when it was commanded and proven to the train."""
    commanded = found(entries, terminal, "points_commanded", unit="K1", section=section, points=points)
    found(entries, "world", "points_unlocked", points=points)
    moving = found(entries, "world", "points_moving", points=points, target="normal")
    locked = found(entries, "world", "points_locked", points=points, position="normal")
    assert locked["t"] - moving["t"] == pytest.approx(THROW_S)
    found(entries, terminal, "points_proven", unit="K1", section=section, points=points)
    proven = found(entries, "K1", "proven", points=points, position="normal")
    return commanded["t"], proven["t"]


def test_the_sequence_of_the_paper(journal: list[Entry]) -> None:
    entries = iter(journal)
    # the whole route in one request, granted whole
    found(entries, "K1", "sent", receiver="block-manager", kind="RouteRequest")
    found(entries, "block-manager", "granted", unit="K1", sections=["5", "6", "7", "8"])
    found(entries, "K1", "route_held")
    # pattern to the departure points, throw, pattern to the next points
    found(entries, "K1", "stop_limit", before="5", why="points not proven")
    _, proven_s = throw(entries, "P5", "A-E", "5")
    beyond = found(entries, "K1", "stop_limit", before="7", why="points not proven")
    assert beyond["t"] == proven_s
    found(entries, "K1", "departs", station="A")
    # the approach tag throws the arrival points; pattern to the platform
    tag = found(entries, "K1", "tag_read", purpose="approach")
    commanded_s, proven_s = throw(entries, "P7", "B-W", "7")
    assert commanded_s - tag["t"] <= 0.2
    platform = found(entries, "K1", "stop_limit", piece="8", before=None)
    assert platform["t"] == proven_s
    arrived = found(entries, "K1", "arrived", station="B")
    assert abs(arrived["error_m"]) <= 1.0


def test_sections_are_released_at_the_arrival_tag_and_only_by_the_train_that_left_them(
    journal: list[Entry],
) -> None:
    freed = [entry for entry in journal if entry["what"] == "freed"]
    assert [entry["sections"] for entry in freed] == [["3", "5", "6", "7"]]
    tag = found(iter(journal), "K1", "tag_read", purpose="arrival")
    assert 0.0 <= freed[0]["t"] - tag["t"] <= 1.0
    for entry in freed:
        reported = [
            e
            for e in journal
            if e["what"] == "reported" and e["t"] < entry["t"] and e["who"] == entry["unit"]
        ]
        assert reported
        assert not set(entry["sections"]) & set(reported[-1]["sections"])


def test_the_train_keeps_the_platform_when_it_stands_there(journal: list[Entry]) -> None:
    last = [entry for entry in journal if entry["who"] == "K1" and entry["what"] == "holds"][-1]
    assert last["sections"] == ["8"]


def test_points_move_only_while_their_section_is_held_by_the_train_that_commands(
    journal: list[Entry],
) -> None:
    held: set[str] = set()
    section_of = {"P5": "5", "P7": "7"}
    thrown = 0
    for entry in journal:
        if entry["who"] == "block-manager" and entry["what"] in ("granted", "accepted"):
            held |= set(entry["sections"])
        elif entry["what"] == "freed":
            held -= set(entry["sections"])
        elif entry["what"] in ("points_unlocked", "points_moving"):
            assert section_of[entry["points"]] in held
            thrown += entry["what"] == "points_moving"
    assert thrown == 2
