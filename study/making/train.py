"""A new train file: a shipped one with its keys explained, or one with figures of one's own in their places."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from network.errors import COMMAND_LINE, InputError
from network.files.schema_walk import resolved_node
from network.files.text_input import existing_file
from network.files.toml_input import parse_table, read_text
from network.raw import is_table
from scenario.schemas import schema_of
from study.making.place import checked_new, write_new
from vehicle.train_file import TrainType, load_train, shipped_train

COMMENT_AT: Final = 44  # column where explanations begin
_HEADING: Final = re.compile(r"\[ *([a-z_]+) *\] *(?:#.*)?")
_KEY: Final = re.compile(r"([a-z0-9_]+) *= *(.*)")


@dataclass(frozen=True, slots=True)
class Figures:
    """Figures of one's own, as written; None: that of the train it is made from."""

    name: str | None = None
    length_m: float | None = None
    mass_t: float | None = None
    cars: int | None = None
    power_kw: float | None = None
    force_kn: float | None = None
    max_speed_kmh: float | None = None


# Option, table, beginning of the key, its unit in the option, and the units a file may have, with what one is of that.
_PLACES: Final[tuple[tuple[str, str, str, Mapping[str, float]], ...]] = (
    ("length_m", "body", "length", {"m": 1.0}),
    ("mass_t", "body", "mass_empty", {"t": 1.0, "kg": 1000.0}),
    ("cars", "body", "cars", {"": 1.0}),
    ("max_speed_kmh", "body", "speed_max", {"kmh": 1.0, "mps": 1.0 / 3.6}),
    ("power_kw", "traction", "power_max", {"kw": 1.0, "w": 1000.0}),
    ("force_kn", "traction", "force_max", {"kn": 1.0, "n": 1000.0}),
)


def new_train(like: str, out: Path, figures: Figures) -> TrainType:
    """Write a train file and read it again; nothing stays of one that cannot be. InputError."""
    stem = checked_new(out)
    source = Path(like) if like.endswith(".toml") and existing_file(Path(like)) else shipped_train(like)
    text = train_text(read_text(source), stem, figures, like)
    write_new(out, text)
    try:
        return load_train(out)
    except InputError as error:
        out.unlink()
        raise InputError(COMMAND_LINE, error.key, error.value, error.expected) from error


def train_text(text: str, stem: str, figures: Figures, like: str) -> str:
    """The new file: the old one's lines, each key with what it means, own figures in their places, named as given."""
    schema, named = schema_of("train"), {"id": stem, "name": figures.name or stem}
    given = _own_figures(text, figures, like)
    left = dict(given)
    rows = [
        f"# A kind of train, begun from {like}. `branchline check` and `run` name what cannot be; every figure has its",
        "# source, or `assumed: why`, in [provenance]. A figure may be in other units: docs/files.md lists them.",
        "",
    ]
    table = ""
    for line in text.splitlines():
        heading, key = _HEADING.fullmatch(line.strip()), _KEY.match(line)
        if heading is not None:
            table = heading[1]
        if line.startswith("#") and not table:
            continue  # says what the old train is
        if key is None or table == "provenance":
            if not any(line.startswith(f'"{table_key}"') for table_key in given):
                rows.append(line)
            if heading is not None and table == "provenance":
                rows += [f'"{own}" = "given to `branchline new train`"' for own in given]
            continue
        name, value = key[1], key[2].split(" #")[0].rstrip()
        value = left.pop(f"{table}.{name}", value)
        if not table and name in named:
            value = json.dumps(named[name], ensure_ascii=False)
        rows.append(_explained(f"{name} = {value}", _meaning(schema, table, name)))
    if left:
        raise InputError(
            like, next(iter(left)), None, "a line of its own in its table, for another figure to be put in"
        )
    return "\n".join(rows) + "\n"


def _own_figures(text: str, figures: Figures, like: str) -> dict[str, str]:
    """Own figures by table and key, in the unit that the file has."""
    tables, found = parse_table(text, like), dict[str, str]()
    for option, table, begin, units in _PLACES:
        value = getattr(figures, option)
        if value is None:
            continue
        keys = {f"{begin}_{unit}" if unit else begin: share for unit, share in units.items()}
        key = next((key for key in keys if key in tables.get(table, {})), None)
        if key is None:
            raise InputError(
                COMMAND_LINE, f"--{option.replace('_', '-')}", value, "a train whose file has it"
            )
        scaled = value * keys[key]
        found[f"{table}.{key}"] = f"{scaled:g}" if option == "cars" else repr(float(scaled))
    return found


def _explained(row: str, meaning: str) -> str:
    return f"{row.ljust(COMMENT_AT - 1)} # {meaning}" if meaning else row


def _meaning(schema: Mapping[str, Any], table: str, key: str) -> str:
    properties = schema["properties"]
    if table:
        properties = resolved_node(schema, properties[table]).get("properties", {})
    node = properties.get(key, {})
    return str(node.get("description", "")) if is_table(node) else ""
