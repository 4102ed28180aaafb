"""Text of files: a mark is read over, another encoding is named, size and nesting have an end."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.errors import EXPECTED_MAX, SHOWN_MAX, InputError, shown_value
from network.files import json_input, text_input
from network.files.json_input import read_json
from network.files.shipped import shipped_line, shipped_timetable
from network.files.text_input import NESTING_MAX, TOML_BYTES_MAX, existing_file, read_text
from network.files.toml_input import parse_table
from study.drilling.drill import sentence_of
from vehicle.train_file import read_train, shipped_train

TEXT = 'name = "烏山線、宝積寺から烏山まで"\n# 転てつ器の転換\n'
LINE = shipped_line("karasuyama").read_text("utf-8")


def refused(read: Callable[[Path], object], path: Path, data: bytes) -> str:
    path.write_bytes(data)
    with pytest.raises(InputError) as error:
        read(path)
    assert error.value.file == str(path)
    return error.value.expected


def test_a_mark_of_utf_8_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes(b"\xef\xbb\xbf" + TEXT.encode())
    assert read_text(path) == TEXT


@pytest.mark.parametrize("text", [TEXT, LINE])
@pytest.mark.parametrize(
    ("codec", "name", "command"),
    [
        ("cp932", "Shift-JIS", "iconv -f CP932 -t UTF-8"),
        ("euc_jp", "EUC-JP", "iconv -f EUC-JP -t UTF-8"),
        ("utf-16", "UTF-16", "iconv -f UTF-16 -t UTF-8"),
        ("utf-16-le", "UTF-16LE", "iconv -f UTF-16LE"),
        ("utf-16-be", "UTF-16BE", "iconv -f UTF-16BE"),
        ("utf-32", "UTF-32", "iconv -f UTF-32 -t UTF-8"),
    ],
)
def test_another_encoding_is_named_with_how_to_convert_it(
    tmp_path: Path, text: str, codec: str, name: str, command: str
) -> None:
    if text == TEXT and codec.startswith("utf-16-"):
        text = "# " + "a" * 200 + text  # without a mark it is known by the zeros of Latin letters
    expected = refused(read_text, tmp_path / "a.toml", text.encode(codec, errors="replace"))
    assert f"in {name};" in expected and command in expected


@given(st.integers(0, 10_000), st.integers(0x80, 0xFF))
def test_a_damaged_utf_8_is_not_taken_for_shift_jis(place: int, byte: int) -> None:
    data = bytearray(LINE.encode())
    data[place % len(data)] = byte
    try:
        text_input._decoded("f", bytes(data))
    except InputError as error:
        assert "in line " in error.expected and "Shift-JIS" not in error.expected


@pytest.mark.parametrize(
    ("data", "words"),
    [(b"a = 1\nb = \xff\n", "byte 0xff in line 2"), (b"\x80", "byte 0x80 in line 1")],
)
def test_what_is_no_text_says_where(tmp_path: Path, data: bytes, words: str) -> None:
    assert words in refused(read_text, tmp_path / "a.toml", data)


def test_a_file_has_an_end(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes(b"#" * TOML_BYTES_MAX)
    assert len(read_text(path)) == TOML_BYTES_MAX
    assert "at most 1 MiB" in refused(read_text, path, b"#" * (TOML_BYTES_MAX + 1))


@pytest.mark.parametrize("kind", ["folder", "pipe", "missing", "too long", "zero byte"])
def test_what_is_no_file_is_no_input(tmp_path: Path, kind: str) -> None:
    """A pipe that nobody writes to would be waited on for ever."""
    path = tmp_path / {"too long": "x" * 300, "zero byte": "a\0b"}.get(kind, "here")
    if kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    assert not existing_file(path)
    with pytest.raises(InputError, match=r"a readable file|no pipe or device"):
        read_text(path)


DEEP = {
    "arrays": "a = " + "[" * 5000 + "]" * 5000,
    "inline tables": "a = " + "{ a = " * 5000 + "1" + " }" * 5000,
    "a header": "[" + ".".join("a" * 5000) + "]\n",
    "dotted keys": ".".join("a" * 5000) + " = 1\n",
    "one level too many": "a = " + "[" * (NESTING_MAX + 1) + "]" * (NESTING_MAX + 1),
}


@pytest.mark.parametrize("name", DEEP)
def test_toml_is_only_so_deep(name: str) -> None:
    with pytest.raises(InputError, match=f"at most {NESTING_MAX} levels"):
        parse_table(DEEP[name], "f.toml")
    assert parse_table("a = " + "[" * NESTING_MAX + "]" * NESTING_MAX, "f.toml")


@pytest.mark.parametrize("depth", [NESTING_MAX + 2, 1_000_000])
def test_json_is_only_so_deep(tmp_path: Path, depth: int) -> None:
    expected = refused(lambda path: read_json(path, object), tmp_path / "a.json", b"[" * depth + b"]" * depth)
    assert f"at most {NESTING_MAX} levels" in expected


def test_without_the_cap_a_deep_file_goes_on_to_where_python_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the cap guards: whoever walks the tables by recursion (a patch copies them) would end in a traceback."""
    from copy import deepcopy

    monkeypatch.setattr("network.files.toml_input.check_nesting", lambda *_: None)
    with pytest.raises(RecursionError):
        deepcopy(parse_table(DEEP["a header"], "f.toml"))


def test_what_one_reader_does_to_a_text_that_is_parsed_once_no_other_sees() -> None:
    parse_table("[a]\nb = [1]\n", "f.toml")["a"]["b"].append(2)
    assert parse_table("[a]\nb = [1]\n", "f.toml") == {"a": {"b": [1]}}


@pytest.mark.parametrize("text", ["a = 1" + "0" * 5000, "a = 0x" + "f" * 9000 + "\n[[a]]"])
def test_a_number_of_thousands_of_digits_is_no_traceback(text: str) -> None:
    with pytest.raises(InputError, match="valid TOML"):
        parse_table(text, "f.toml")


READERS: dict[str, tuple[Callable[[Path], object], bytes]] = {
    "line": (lambda p: parse_table(read_text(p), "f"), LINE.encode()),
    "timetable": (lambda p: parse_table(read_text(p), "f"), shipped_timetable("karasuyama_weekday").read_bytes()),
    "train": (read_train, shipped_train("ev_e301").read_bytes()),
    "JSON": (lambda p: read_json(p, object), b'{"a": 1}'),
    "a drill's sentence": (lambda p: sentence_of(str(p)), b'name = "x"'),
}  # fmt: skip


@pytest.mark.parametrize("kind", READERS)
def test_every_reader_takes_the_mark_and_names_shift_jis(tmp_path: Path, kind: str) -> None:
    read, data = READERS[kind]
    path = tmp_path / "a.toml"
    path.write_bytes(data)
    plain = read(path)
    path.write_bytes(b"\xef\xbb\xbf" + data)
    assert read(path) == plain
    assert "Shift-JIS" in refused(read, path, "# 烏山線\n".encode("cp932") + data[:0])


def test_size_of_json_is_bounded_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(json_input, "JSON_BYTES_MAX", 1 << 20)
    expected = refused(lambda path: read_json(path, object), tmp_path / "a.json", b" " * (1 << 20) + b"1")
    assert "at most 1 MiB" in expected


VALUES: list[Any] = [
    "x" * 10**6,
    ["y" * 1000] * 1000,
    {"a": {"b": 1}},
    16**9000,
    1e300,
    "a\nb",
    "\x1b[2J",
    True,
    float("nan"),
]


@pytest.mark.parametrize("value", VALUES, ids=range(len(VALUES)))
def test_a_message_is_one_line_with_a_value_that_is_cut(value: object) -> None:
    assert len(shown_value(value)) <= SHOWN_MAX
    text = str(InputError("f.toml", "a.b", value, "something else"))
    assert text.isprintable() and len(text) < 150
    assert text.startswith("f.toml: a.b is ") and text.endswith("; expected something else")


def test_a_key_and_what_a_file_calls_its_own_are_cut_and_escaped_too() -> None:
    text = str(InputError("f.toml", "k\n" * 1000, 1, "one of " + "a\x07" * EXPECTED_MAX))
    assert text.isprintable() and len(text) < EXPECTED_MAX + 200


@pytest.mark.parametrize(
    ("value", "words"), [(True, "true"), (0.5, "0.5"), ("a", "'a'"), ([1, "b"], "[1, 'b']")]
)
def test_values_are_shown_as_a_file_spells_them(value: object, words: str) -> None:
    assert shown_value(value) == words
