"""The pages of files are what the schemas say, and the schemas say something of every key."""

import json
import tomllib
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from documents.files import UNIT_OF, pages, tables_of
from network.errors import InputError
from network.files.line_schema import LineFile
from network.files.schema_walk import json_schema_of, resolved_node
from network.files.shipped import shipped_line
from scenario import schemas
from scenario.scenario import shipped_scenarios
from scenario.scenario_file import ScenarioFile
from scenario.schemas import FILES, other_keys, schema_of
from tests.nightly import others_nightly
from vehicle.train_file import TRAINS_FOLDER, _table_in_si

# Faults, acts and expectations are types of their own: what their keys mean is said with each.
SCRIPT = ("[[fault]]", "[[act]]", "[[expect]]")


def rows() -> Iterator[tuple[str, tuple[str, ...]]]:
    for kind in FILES:
        for heading, _, found in tables_of(json_schema_of(kind.model)):
            if not any(name in heading for name in SCRIPT):
                yield from ((f"{kind.model.__name__} {heading}", row) for row in found)


def test_there_is_a_page_for_each_kind_of_file() -> None:
    assert {file.stem for file in dict(pages())} == {"files", "ranges", *(kind.name for kind in FILES)}


def test_every_key_has_a_meaning() -> None:
    assert [(where, row[0]) for where, row in rows() if not row[6]] == []


def test_every_figure_with_a_default_says_where_it_comes_from() -> None:
    """Zeros that mean none, switches and places on the map need no source."""
    figures = [
        (where, row[0])
        for where, row in rows()
        if where.startswith("ScenarioFile")
        and row[1] == "number"
        and row[4] not in ("needed", "–")
        and not row[7]
    ]
    assert figures == []


def test_every_key_that_ends_in_a_unit_shows_it() -> None:
    for where, row in rows():
        key = row[0].strip("`")
        if row[1] == "number" and any(key.endswith(ending) for ending in UNIT_OF):
            assert row[2], (where, key)


def test_every_setting_of_a_run_has_a_range() -> None:
    """A number that a run reads is bounded on at least one side; factors of patches are judged by their result."""
    for where, row in rows():
        if where.startswith("ScenarioFile") and "patch" not in where and row[1] == "number":
            assert row[3], (where, row[0])


@pytest.mark.parametrize("kind", others_nightly(schemas.KINDS, list(schemas.KINDS)[:2]))
def test_the_command_prints_a_schema(main: Callable[..., Any], kind: str) -> None:
    ended = main("schema", kind)
    assert ended.code == 0
    assert ended.figures() == json.loads(json.dumps(schema_of(kind)))


def test_without_a_kind_it_prints_all_of_them(main: Callable[..., Any]) -> None:
    assert set(main("schema").figures()) == set(schemas.KINDS)


def test_an_unknown_kind_lists_the_known_ones(main: Callable[..., Any]) -> None:
    assert main("schema", "train_type").code == 2
    with pytest.raises(InputError, match="one of line, timetable, train, scenario, drill"):
        schema_of("train_type")


def test_keys_in_other_units_are_those_that_the_reader_converts() -> None:
    """The schema's other keys of a figure and the reader's agree, factor and all."""
    for key in (
        "force_max_n",
        "speed_max_mps",
        "mass_empty_kg",
        "notch_deceleration_mps2",
        "wheel_diameter_m",
    ):
        others = other_keys(key)
        assert others
        for other, factor in others.items():
            assert _table_in_si("f", "t", {other: 2.0}, {})[key] == pytest.approx(2.0 * factor)


def test_the_schemas_name_the_keys_of_the_shipped_files() -> None:
    data = tomllib.loads(shipped_line("busy_line").read_text("utf-8"))
    assert set(data) <= set(json_schema_of(LineFile)["properties"])
    train = schema_of("train")
    for file in TRAINS_FOLDER.glob("*.toml"):
        for name, values in tomllib.loads(file.read_text("utf-8")).items():
            if isinstance(values, dict) and name != "provenance":
                table = resolved_node(train, train["properties"][name])
                assert set(values) <= set(table["properties"]), (file, name)
    assert shipped_scenarios()
    assert "patch" in json_schema_of(ScenarioFile)["properties"]
