"""The page brings the Japanese characters that it shows."""

import re
from base64 import b64decode
from importlib.resources import files
from io import BytesIO
from pathlib import Path

import pytest
from fontTools.ttLib import TTFont

from study.report import face
from study.report.bundle import modules, style_sheet
from study.report.face import FACE, FAMILY, japanese_face


def characters_of(made: str) -> set[str]:
    found = re.fullmatch(
        rf'@font-face {{ font-family: "{FAMILY}"; src: url\(data:font/woff;base64,([^)]+)\) format\("woff"\); }}',
        made,
    )
    assert found is not None
    with TTFont(BytesIO(b64decode(found[1]))) as font:
        return {chr(code) for code in font.getBestCmap()}


def test_the_face_has_the_characters_of_the_page_and_no_more() -> None:
    page_face = japanese_face("<h1>Karasuyama Line 烏山線</h1> · 宝積寺 → 1,5 m")
    assert characters_of(page_face) == set("烏山線宝積寺")
    assert len(page_face) < 20_000


def test_the_same_characters_give_the_same_text() -> None:
    assert japanese_face("烏山線") == japanese_face("線 and 山 and 烏")


def test_a_face_is_made_once_and_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[list[int]] = []
    subset = face._subset

    def counted(path: Path, wanted: list[int]) -> bytes:
        made.append(wanted)
        return subset(path, wanted)

    monkeypatch.setattr(face, "_subset", counted)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    first, again, other = japanese_face("烏山線"), japanese_face("線と山と烏"), japanese_face("山")
    assert [[chr(code) for code in wanted] for wanted in made] == [
        sorted("烏山線"),
        sorted("烏山線と"),
        ["山"],
    ]
    assert first == japanese_face("山 線 烏")
    assert len(made) == 3
    assert characters_of(again) > characters_of(first) > characters_of(other)


def test_a_page_without_any_has_no_face() -> None:
    assert japanese_face("Karasuyama – Hōshakuji") == ""


def test_the_template_has_the_place_and_names_the_face() -> None:
    template = (files("study") / "templates" / "report.html.j2").read_text("utf-8")
    assert template.count(FACE) == 1
    assert f'"{FAMILY}", sans-serif' in style_sheet()
    assert f'"{FAMILY}", sans-serif' in modules()["layer.js"]
