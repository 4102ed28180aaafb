"""What the documentation says of a key, and times as a file writes them; figures are in `network.files.quantities`."""

from __future__ import annotations

import re
from typing import Annotated, Any, Final, cast

from pydantic import BeforeValidator, Field, WithJsonSchema
from pydantic.fields import FieldInfo

_CLOCK: Final = re.compile(r"([0-2]?\d):([0-5]\d)(?::([0-5]\d))?")


# Entries of a list, assumed: several times what the longest lines have; what is made of them grows faster than they do.
TABLES_MAX: Final = 2000
ROWS_MAX: Final = 5000
TEXTS_MAX: Final = 500


def about(meaning: str, origin: str = "") -> FieldInfo:
    """What a key means and where its default comes from (a section of a paper, or `assumed: why`).

    Stands in `Annotated` behind the kind: `Annotated[Share, about("…", "assumed: …")] = 0.8`. The unit is the
    ending of the key's name, so it is not said again.
    """
    extra: dict[str, Any] = {"origin": origin} if origin else {}
    info: FieldInfo = Field(description=meaning, json_schema_extra=extra)
    return info


def origin_of(info: FieldInfo) -> str:
    """Where the default of a key comes from, as `about` was told; empty where nobody did."""
    extra = cast("dict[str, str]", info.json_schema_extra or {})
    return extra.get("origin", "")


def _seconds(value: object) -> object:
    """Seconds after midnight of a written time; a number stays one, for settings made in Python."""
    if not isinstance(value, str):
        return value
    found = _CLOCK.fullmatch(value)
    if found is None:
        raise ValueError("a time as HH:MM (24:00 and later are after midnight)")
    return 3600.0 * int(found[1]) + 60.0 * int(found[2]) + float(found[3] or 0)


TimeOfDay = Annotated[
    float,
    BeforeValidator(_seconds),
    Field(ge=0, le=108_000),
    WithJsonSchema({"type": "string", "format": "HH:MM"}),
]
