"""Every key of every kind of file has an example that is accepted where it stands; every error lists every choice."""

import re
from collections.abc import Iterator, Mapping
from copy import deepcopy
from typing import Any

import pytest

from documents.files import tables_of
from network.errors import InputError
from network.files.schema_walk import json_schema_of, resolved_node
from network.files.toml_input import CHOICES_CHARACTERS_MAX, one_of, validate
from network.raw import is_row, is_table
from scenario.key_examples import child_of, filled_example, with_examples
from scenario.schemas import FILES, KINDS, LINE, FileKind, schema_of

EVERY = pytest.mark.parametrize("kind", FILES, ids=lambda kind: kind.name)
Path = tuple[str | int, ...]


def leaves(schema: Mapping[str, Any], node: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    """Every key that holds a plain value, with its node."""
    for key, own in node["properties"].items():
        child = child_of(schema, own)
        if child is not None:
            yield from leaves(schema, child, f"{path}.{key}")
        else:
            yield f"{path}.{key}", own


@EVERY
def test_the_examples_are_of_their_form(kind: FileKind) -> None:
    validate(kind.example(), kind.name, kind.model)


@pytest.mark.parametrize("kind", list(KINDS))
def test_every_key_of_the_schema_has_an_example(kind: str) -> None:
    schema = schema_of(kind)
    assert not [path for path, own in leaves(schema, schema) if not own.get("examples")]


@EVERY
def test_every_row_of_the_page_has_an_example(kind: FileKind) -> None:
    rows = [row for _, _, rows in tables_of(kind.schema()) for row in rows]
    assert len(rows) > 15
    assert not [row[0] for row in rows if not row[5]]


def test_a_key_that_no_file_has_is_found_out() -> None:
    schema = {"properties": {"id": {"type": "string"}, "strange": {"type": "string"}}}
    own = with_examples(schema, filled_example(schema, {"id": "slow_morning"}))
    assert own["properties"]["id"]["examples"] == ["slow_morning"]
    assert "examples" not in own["properties"]["strange"]


def test_a_default_is_the_example_of_a_key_that_the_file_leaves_out() -> None:
    plain = {"type": "number", "default": 2.0}
    schema = {
        "properties": {"other": plain, "table": {"$ref": "#/$defs/T"}},
        "$defs": {"T": {"properties": {"own": plain}}},
    }
    assert filled_example(schema, {"other": 3.0}) == {"other": 3.0, "table": {"own": 2.0}}


def test_an_example_of_another_unit_is_the_same_figure() -> None:
    body = schema_of("train")["$defs"]["_Body"]["properties"]
    assert body["mass_empty_kg"]["examples"] == [77200.0]
    assert body["mass_empty_t"]["examples"] == [77.2]


# choices ----------------------------------------------------------------------------------------------------------


def choices(field: Mapping[str, Any]) -> tuple[str, ...]:
    """The words that a key may say; none where it may say anything."""
    if "const" in field:
        return (str(field["const"]),)
    return tuple(str(value) for value in field.get("enum", ()))


def places(
    schema: Mapping[str, Any], node: Mapping[str, Any], data: Mapping[str, Any], path: Path = ()
) -> Iterator[tuple[Path, tuple[str, ...]]]:
    """Where a file has a key whose words are counted, and these words."""
    for key, value in data.items():
        if key not in node.get("properties", {}):
            continue
        own = node["properties"][key]
        field, child = resolved_node(schema, own), child_of(schema, own)
        if child is not None:
            for where, item in below(value, (*path, key)):
                yield from places(schema, child, item, where)
        elif choices(field):
            yield (*path, key), choices(field)
        elif is_table(field.get("items")) and choices(resolved_node(schema, field["items"])):
            yield (*path, key, 0), choices(resolved_node(schema, field["items"]))


def below(value: object, path: Path) -> Iterator[tuple[Path, Mapping[str, Any]]]:
    if is_row(value):
        yield from (((*path, i), item) for i, item in enumerate(value) if is_table(item))
    elif is_table(value):
        yield path, value
        yield from (((*path, name), item) for name, item in value.items() if is_table(item))


EXAMPLES = {kind.name: kind.example() for kind in FILES}


def all_places() -> Iterator[tuple[FileKind, Path, tuple[str, ...]]]:
    for kind in FILES:
        schema = json_schema_of(kind.model)
        seen: set[str] = set()
        for path, words in places(schema, schema, EXAMPLES[kind.name]):
            if str(path) not in seen:
                seen.add(str(path))
                yield kind, path, words


PLACES = list(all_places())


def test_places_with_choices_are_found() -> None:
    found = {(kind.name, path[-1] if isinstance(path[-1], str) else path[-2]) for kind, path, _ in PLACES}
    assert {
        ("line", "kind"),
        ("line", "directions"),
        ("line", "purpose"),
        ("timetable", "direction"),
        ("train", "regenerated_to"),
        ("scenario", "delay_shape"),
        ("scenario", "reentry"),
    } <= found


@pytest.mark.parametrize(
    ("kind", "path", "words"), PLACES, ids=[f"{kind.name}-{path}" for kind, path, _ in PLACES]
)
def test_an_error_lists_every_choice(kind: FileKind, path: Path, words: tuple[str, ...]) -> None:
    data: Any = deepcopy(EXAMPLES[kind.name])
    *above, last = path
    table = data
    for part in above:
        table = table[part]
    table[last] = "nonsense"
    with pytest.raises(InputError) as refused:
        validate(data, kind.name, kind.model)
    text = str(refused.value)
    assert all(re.search(rf"(?<!\w){re.escape(word)}(?!\w)", text) for word in words), text


def test_a_long_list_of_ids_is_whole_and_begins_with_the_nearest() -> None:
    names = [f"{number}M" for number in range(1, 501)]
    text = one_of(names, "321X")
    assert text.startswith("one of 321M, ")
    assert sorted(text.removeprefix("one of ").split(", ")) == sorted(names)
    shown = str(InputError("a.toml", "trains", "321X", text))
    assert all(name in shown for name in names)


def test_what_no_message_can_hold_says_how_much_it_leaves_out() -> None:
    names = [f"{number:064d}" for number in range(1000)]
    text = one_of(names)
    assert len(text) < CHOICES_CHARACTERS_MAX + 200
    assert int(text.rpartition(" and ")[2].removesuffix(" more")) + text.count(",") + 1 == len(names)


def test_unknown_keys_list_every_key() -> None:
    data = LINE.example()
    data["points"][0]["colour"] = "red"
    with pytest.raises(InputError) as refused:
        validate(data, "line", LINE.model)
    properties = schema_of("line")["$defs"]["PointsTable"]["properties"]
    assert all(name in refused.value.expected for name in properties)
