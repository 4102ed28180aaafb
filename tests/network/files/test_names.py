"""Identifiers are no paths, and text has nothing that cannot be shown."""

from pathlib import Path, PurePosixPath, PureWindowsPath

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from network.files.names import (
    IDENTIFIER_LENGTH_MAX,
    PROSE_LENGTH_MAX,
    TITLE_LENGTH_MAX,
    Identifier,
    Prose,
    Title,
    is_identifier,
    title_of,
)

GOOD = [
    "A",
    "1",
    "323M",
    "HSK.MD",
    "OGN-KRS",
    "karasuyama_weekday",
    "E346M",
    "A.1",
    "a" * IDENTIFIER_LENGTH_MAX,
    "con1",
    "nullo",
]
BAD = [
    "", ".", "..", "...", "../..", "a/b", "a\\b", "/etc/passwd", "C:", "a:b", "-rf", ".hidden", "_a", "a.",
    "a b", " a", "a ", "a\n", "a\x00", "a\x1b[2J", "\u202ea", "烏山", "ａ", "é", "*", "a?",
    "a#b", "$a", "a" * (IDENTIFIER_LENGTH_MAX + 1),
    "con", "CON", "nul", "aux.toml", "Com1", "LPT9.x.y", "prn.",
]  # fmt: skip


# What turns the direction of the text, ends its line, or has no width: Unicode 16, chapter 23.
UNSEEN = [f"a{mark}b" for mark in "\u061c\u200b\u200e\u202e\u2028\u2029\u2066\u2069\ufeff\U000e0041"]


@pytest.mark.parametrize("text", GOOD)
def test_an_identifier(text: str) -> None:
    assert TypeAdapter(Identifier).validate_python(text) == text


@pytest.mark.parametrize("text", BAD)
def test_no_identifier(text: str) -> None:
    with pytest.raises(ValidationError, match="an identifier"):
        TypeAdapter(Identifier).validate_python(text)


@given(st.text(alphabet="a.-_/\\:\x00\n烏C~ON*", max_size=70))
def test_an_identifier_is_one_step_of_a_path_and_no_special_one(text: str) -> None:
    if is_identifier(text):
        assert PurePosixPath(text).parts == (text,) == PureWindowsPath(text).parts
        assert (Path("/runs") / text).parent == Path("/runs")
        assert (Path("/runs") / text).resolve().parent == Path("/runs")
        assert text.isascii() and text.isprintable() and not set(text) & set("*$?#/")


@pytest.mark.parametrize(("kind", "length"), [(Title, TITLE_LENGTH_MAX), (Prose, PROSE_LENGTH_MAX)])
def test_text_is_bounded_and_shows(kind: object, length: int) -> None:
    take = TypeAdapter(kind).validate_python
    assert take("烏山線" * (length // 3)) == "烏山線" * (length // 3)
    assert take("व\u200dय, می\u200cشود, 辻\U000e0100") != ""
    for bad in ("x" * (length + 1), "a\x00b", "a\x1b[2J", "\x7f", "\x85", *UNSEEN):
        with pytest.raises(ValidationError, match="control character"):
            take(bad)


@given(st.text(max_size=300))
def test_whatever_is_made_a_title_is_one(text: str) -> None:
    assert TypeAdapter(Title).validate_python(title_of(text)) == title_of(text)


@pytest.mark.parametrize("text", UNSEEN)
def test_a_title_that_is_made_leaves_out_what_is_not_seen(text: str) -> None:
    assert title_of(text).replace(" ", "") == "ab"
