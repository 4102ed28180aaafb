"""Files written whole or not at all, and none of another kind replaced."""

from pathlib import Path

import pytest

from network.errors import InputError
from network.files.json_input import write_bytes_aside, writing_aside


def test_a_file_of_another_kind_is_not_replaced(tmp_path: Path) -> None:
    """A feed written over a scenario, by a slip, would be the end of the scenario."""
    out = tmp_path / "day.toml"
    for _ in range(2):
        write_bytes_aside(out, b"PK one", b"PK")
    out.write_text('id = "day"\n', "utf-8")
    with pytest.raises(InputError, match=r"day\.toml; expected a new file, or one of the same kind"):
        write_bytes_aside(out, b"PK two", b"PK")
    assert out.read_text("utf-8") == 'id = "day"\n'
    write_bytes_aside(out, b"anything")
    assert [path.name for path in tmp_path.iterdir()] == ["day.toml"]


@pytest.mark.parametrize("name", [".", "folder", "no/such/folder/file"])
def test_a_path_that_takes_no_file_is_named_and_nothing_is_left(tmp_path: Path, name: str) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError), writing_aside(tmp_path / name if name != "." else Path()) as stream:
        stream.write(b"half")
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


def test_what_fails_half_way_leaves_the_file_that_was_there(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"old")
    with pytest.raises(ZeroDivisionError), writing_aside(tmp_path / "file") as stream:
        stream.write(b"new, by half")
        raise ZeroDivisionError
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("file", b"old")]
