"""What the head of the page is made of: facts in two languages; and how a figure with a sign is set."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Fact:
    """One line of the headline, in English and in Japanese; `bad` is set in red."""

    name: str
    value: str
    bad: bool = False
    name_ja: str = ""
    value_ja: str = ""


def signed(value: float, digits: int = 0, unit: str = "") -> str:
    """A number with its sign, as it is set: +3 s, −12 s."""
    text = f"{value:+,.{digits}f}"
    return f"{text} {unit}".rstrip().replace("-", "−")
