"""The page brings the Japanese characters that it shows."""

from __future__ import annotations

import re
from base64 import b64decode
from importlib.resources import files
from io import BytesIO

from fontTools.ttLib import TTFont

from study.report.bundle import modules, style_sheet
from study.report.face import FACE, FAMILY, japanese_face


def characters_of(face: str) -> set[str]:
    found = re.fullmatch(
        rf'@font-face {{ font-family: "{FAMILY}"; src: url\(data:font/woff;base64,([^)]+)\) format\("woff"\); }}',
        face,
    )
    assert found is not None
    with TTFont(BytesIO(b64decode(found[1]))) as font:
        return {chr(code) for code in font.getBestCmap()}


def test_the_face_has_the_characters_of_the_page_and_no_more() -> None:
    face = japanese_face("<h1>Karasuyama Line 烏山線</h1> · 宝積寺 → 1,5 m")
    assert characters_of(face) == set("烏山線宝積寺")
    assert len(face) < 20_000


def test_the_same_characters_give_the_same_text() -> None:
    assert japanese_face("烏山線") == japanese_face("線 and 山 and 烏")


def test_a_page_without_any_has_no_face() -> None:
    assert japanese_face("Karasuyama – Hōshakuji") == ""


def test_the_template_has_the_place_and_names_the_face() -> None:
    template = (files("study") / "templates" / "report.html.j2").read_text("utf-8")
    assert template.count(FACE) == 1
    assert f'"{FAMILY}", sans-serif' in style_sheet()
    assert f'"{FAMILY}", sans-serif' in modules()["layer.js"]
