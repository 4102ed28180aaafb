"""The small line of these tests: a portal, two tracks at A, the halt H, two tracks at B."""

from pathlib import Path
from typing import Final

from network.files.line_file import parse_line
from network.model import Line

SAMPLE_FILE: Final = Path(__file__).with_name("sample_line.toml")
SAMPLE: Final = SAMPLE_FILE.read_text("utf-8")
LINE: Final[Line] = parse_line(SAMPLE, "sample.toml")


def changed(old: str, new: str, count: int = 1) -> str:
    """Its file with the first `count` places of `old` replaced; fails when there is none."""
    assert old in SAMPLE, old
    return SAMPLE.replace(old, new, count)
