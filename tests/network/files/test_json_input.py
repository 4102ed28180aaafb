"""Files are written whole or not at all, and nothing is left beside them."""

from pathlib import Path

import pytest

from network.errors import InputError
from network.files.json_input import write_aside


def test_nothing_is_left_where_a_file_cannot_be_put(tmp_path: Path) -> None:
    """A folder is in its place: the text was written aside, and goes."""
    (tmp_path / "line.toml").mkdir()
    with pytest.raises(InputError, match="a writable path"):
        write_aside(tmp_path / "line.toml", "id = 1\n")
    assert [path.name for path in tmp_path.iterdir()] == ["line.toml"]
    write_aside(tmp_path / "other.toml", "id = 1\n")
    assert (tmp_path / "other.toml").read_text("utf-8") == "id = 1\n"
