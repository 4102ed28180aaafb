"""The page docs/files/ranges.md: every kind of figure, what its range rests on, and which keys have it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

from pydantic import BaseModel

from documents.interlocking import table
from network.files.quantities import ALL
from network.files.schema_walk import json_schema_of, resolved_node
from scenario.schemas import LINE, SCENARIO, TIMETABLE, TRAIN
from simulation.faults.table import KINDS as FAULTS
from vehicle.train_checks import RULES

MODELS: Final[tuple[type[BaseModel], ...]] = (
    *(kind.model for kind in (LINE, TIMETABLE, TRAIN, SCENARIO)),
    *FAULTS,
)
HEAD: Final = ("kind", "range", "what it rests on", "keys")
TOGETHER: Final = ("figure", "range", "what it rests on", "of")
INTRO: Final = """# Ranges

Values outside these ranges are refused as nonsense, in every file and after every patch; the ends are allowed. The
ranges are real extremes, rounded outwards, or assumed; what is sensible for a line is for its author to judge. A key in
another unit has the same range, converted.
"""
RULES_INTRO: Final = """## What several figures say together

A train is also refused if several of its figures together make no sense. Computed with the laws that a run uses:
"""
REST: Final = """\
Further: a piece of track is at least 1 m long; no run of a timetable is faster than the fastest train on rails, and no
set's day is longer than three days; the adhesion suffices for the brakes that a scenario guarantees; the emergency
brake does not come before the service brake.
"""


def quantity_keys(model: type[BaseModel]) -> Iterator[tuple[str, str]]:
    """Every number that a file of this model may hold: its key, and the name of its kind; empty if it has none."""
    schema = json_schema_of(model)
    waiting: list[Mapping[str, Any]] = [schema]
    seen: set[int] = set()
    while waiting:
        node = resolved_node(schema, waiting.pop(0))
        if id(node.get("properties")) in seen:
            continue
        seen.add(id(node.get("properties")))
        for key, own in node.get("properties", {}).items():
            field = resolved_node(schema, own)
            while "items" in field:
                field = resolved_node(schema, field["items"])
            if field.get("type") in ("number", "integer"):
                yield key, str(field.get("quantity", ""))
            named = field.get("additionalProperties")
            waiting += [field] + ([named] if isinstance(named, Mapping) else [])


def document() -> str:
    """The whole page."""
    keys: dict[str, list[str]] = {}
    for model in MODELS:
        for key, name in quantity_keys(model):
            if f"`{key}`" not in keys.setdefault(name, []):
                keys[name].append(f"`{key}`")
    rows = [(q.name, q.text(), q.source, ", ".join(keys.get(q.name, ()))) for q in ALL]
    together = [
        (rule.name, rule.text(), rule.source, ", ".join(f"`{key}`" for key in (rule.key, *rule.others)))
        for rule in RULES
    ]
    return "\n".join((INTRO, table(HEAD, rows) + "\n", RULES_INTRO, table(TOGETHER, together) + "\n", REST))
