"""The deliberate mistakes, as `defects.toml` lists them."""

from pathlib import Path
from typing import Literal

import msgspec

ROOT = Path(__file__).resolve().parents[2]


class Planted(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One mistake: a text of a file put for another, and the tests that must fail then."""

    what: str
    kind: Literal["safety", "physics", "figures", "labels", "units"]
    file: str
    was: str
    becomes: str
    tests: list[str]
    interpreted: bool = False

    def planted_in(self, sound: str) -> str:
        """The text of its file with the mistake in it. ValueError where it is not to be found once."""
        if sound.count(self.was) != 1:
            raise ValueError(
                f"{self.what}: {self.file} has its text {sound.count(self.was)} times; expected once"
            )
        return sound.replace(self.was, self.becomes)


class _File(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    defect: list[Planted]


def planted() -> list[Planted]:
    """All of them, in the order of the file."""
    text = (Path(__file__).parent / "defects.toml").read_text("utf-8")
    return msgspec.toml.decode(text, type=_File).defect
