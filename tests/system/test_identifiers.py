"""Every id of every file is an identifier: none is a path, and a run named by one stays where runs are written."""

from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from documents.files import tables_of
from network.files import names
from network.files.schema_walk import json_schema_of
from network.files.shipped import shipped_line, shipped_timetable
from scenario.schemas import FILES
from tests.nightly import others_nightly
from vehicle.train_file import shipped_train

LINE = shipped_line("rtri_test_line").read_text("utf-8")
TIMES = shipped_timetable("rtri_test_line").read_text("utf-8")
TRAIN = shipped_train("ev_e301").read_text("utf-8")
HEAD = 'extends = "rtri_test_line"\nid = "s"\n'

# whose id: what names it in its file, the file, the key
PLACES = {
    "scenario": ('id = "s"', "s.toml", "id"),
    "line": ('id = "rtri_test_line"', "l.toml", "line.id"),
    "axis": ('id = "main"', "l.toml", "alignments[0].id"),
    "section": ('id = "PW"', "l.toml", "sections[0].id"),
    "points": ('id = "P2"', "l.toml", "points[0].id"),
    "terminal": ('terminal = "A-W"', "l.toml", "points[0].terminal"),
    "station": ('[[stations]]\nid = "A"', "l.toml", "stations[0].id"),
    "timetable": ('id = "rtri_test_line"', "t.toml", "timetable.id"),
    "train number": ('number = "T1"', "t.toml", "trains[0].number"),
    "set": ('stock = "K1"', "t.toml", "diagrams[0].stock"),
    "train": ('id = "ev_e301"', "v.toml", "id"),
}
CROSSING = '{{ id = "{}", section = "6", km = 0.75 }}'
PATHS = ["../..", "..", "/tmp/x", "a/b", "a\\\\b", "a\\u0000b", "nul", "a" * 65, "烏山"]


def files(whose: str, text: str) -> dict[str, str]:
    found = {"s.toml": HEAD + 'line = "l.toml"\ntimetable = "t.toml"\n[trains]\ndefault = "v.toml"\n'}
    found |= {"l.toml": LINE, "t.toml": TIMES, "v.toml": TRAIN}
    old, file, _ = PLACES[whose]
    assert old in found[file], old
    name, _, _ = old.rpartition(" = ")
    found[file] = found[file].replace(old, f'{name} = "{text}"', 1)
    return found


# Each place and each text in every run, all of both at night.
PAIRS = others_nightly(
    product(PLACES, PATHS),
    {(whose, PATHS[number % len(PATHS)]) for number, whose in enumerate(PLACES)},
    columns=True,
)


@pytest.mark.parametrize(("whose", "text"), PAIRS)
def test_a_path_is_no_id(main: Callable[..., Any], tmp_path: Path, whose: str, text: str) -> None:
    (tmp_path / "here").mkdir()
    given = files(whose, text)
    for name, content in given.items():
        (tmp_path / name).write_text(content, "utf-8")
    ended = main("run", "s.toml", "--json")
    assert ended.code == 2, ended
    assert ended.err.count("\n") == 1
    assert f"{PLACES[whose][1]}: {PLACES[whose][2]} is " in ended.err
    assert "an identifier" in ended.err
    assert {path.name for path in tmp_path.iterdir()} == {*given, "here"}


def test_every_key_that_names_a_thing_is_an_identifier() -> None:
    """Read off the schemas, so that a new table's id has the type too; ids of tags, beacons and markers are numbers."""
    found = {
        (f"{kind.model.__name__} {heading}", row[0].strip("`")): row[1]
        for kind in FILES
        for heading, _, rows in tables_of(json_schema_of(kind.model))
        for row in rows
        if row[0].strip("`") in ("id", "number", "stock", "terminal")
        and row[1] != "table"
        and "list" not in row[1]
    }
    assert len(found) >= len(PLACES)
    numbered = {(f"LineFile `[[{table}]]`", "id") for table in ("tags", "beacons", "markers")}
    assert {key for key, written in found.items() if written != "identifier"} == numbered


def test_without_the_rule_a_run_would_be_written_elsewhere(
    main: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The defect, with the rule switched off: the folder above holds the user's work, and is taken for the run's."""
    monkeypatch.setattr(names, "is_identifier", lambda _text: True)
    for name, content in files("scenario", "../..").items():
        (tmp_path / name).write_text(content, "utf-8")
    ended = main("run", "s.toml")
    assert ended.code == 2
    assert f"--out is '{tmp_path.parent}'" in ended.err


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('stock = "K1"', 'stock = "block-manager"', "t.toml: diagrams[0].stock is 'block-manager'"),
        ('stock = "K1"', 'stock = "A-W"', "t.toml: diagrams[0].stock is 'A-W'"),
        ('stock = "K1"', 'stock = "world"', "t.toml: diagrams[0].stock is 'world'"),
        ('terminal = "A-W"', 'terminal = "controller"', "l.toml: points.P2.terminal is 'controller'"),
        ("[line]", f"crossings = [{CROSSING.format('K1')}]\n[line]", "t.toml: diagrams[0].stock is 'K1'"),
        (
            "[line]",
            f"crossings = [{CROSSING.format('world')}]\n[line]",
            "l.toml: crossings.world.id is 'world'",
        ),
    ],
)
def test_no_two_parties_have_one_name(
    main: Callable[..., Any], tmp_path: Path, old: str, new: str, key: str
) -> None:
    for name, content in files("scenario", "s").items():
        (tmp_path / name).write_text(content.replace(old, new, 1), "utf-8")
    ended = main("check", "s.toml")
    assert ended.code == 2, ended
    assert key in ended.err and "no other party's" in ended.err
