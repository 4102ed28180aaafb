"""`python -m documents.generated` says which file is not what is generated."""

from pathlib import Path

import pytest

from documents import generated
from documents.generated import differences, main


def test_a_stale_file_is_named_with_its_lines(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    page = Path("docs/page.md")
    (tmp_path / "docs").mkdir()
    (tmp_path / page).write_text("one\ntwo\n", "utf-8")
    monkeypatch.setattr(generated, "generated", lambda: iter([(page, "one\ntwo\n")]))
    assert main(tmp_path) == 0
    monkeypatch.setattr(generated, "generated", lambda: iter([(page, "one\nthree\n")]))
    assert main(tmp_path) == 1
    said = capsys.readouterr().out
    assert "STALE   docs/page.md" in said
    assert "-two" in said
    assert "+three" in said


def test_a_file_that_was_never_committed_is_stale(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(generated, "generated", lambda: iter([(Path("docs/new.md"), "one\n")]))
    assert main(tmp_path) == 1
    assert "+one" in capsys.readouterr().out


def test_differences_are_lines_of_both_sides() -> None:
    assert differences("same\nold\nsame\n", "same\nnew\nsame\n") == ["-old", "+new"]
    assert differences("same\n", "same\n") == []
