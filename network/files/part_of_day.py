"""A part of the day, as tables of files name one: from a time to a later one."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator

from network.files.kinds import TimeOfDay, about
from network.files.toml_input import Record


class PartOfDay(Record):
    """When something holds."""

    from_s: Annotated[TimeOfDay, Field(alias="from"), about("when it begins")]
    to_s: Annotated[TimeOfDay, Field(alias="to"), about("when it ends")]

    @field_validator("to_s")
    @classmethod
    def _later(cls, to_s: float, info: ValidationInfo) -> float:
        if to_s <= info.data.get("from_s", -1.0):
            raise ValueError("a time after that of from")
        return to_s
