"""Labels stand once, in the catalogue: what code, page and pictures say is in it, and nothing else is."""

import ast
import re
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from string import Formatter

import pytest
from babel.messages.extract import extract_javascript

from study.report.bundle import modules, words_of_the_page
from study.wording import catalogue
from study.wording.catalogue import phrase

ROOT = Path(__file__).parents[3]
JAPANESE = re.compile("[ぁ-んァ-ヶ一-龠]")
NO_LABEL = {"study/capacity/headway.py", "study/plot/stations.py"}  # an enum of names, a sign of timetables
# Contexts of what code, template or page say themselves; the others list what enums and files hold.
OWN = (
    "",
    "as run",
    "apart",
    "battery",
    "call",
    "clause",
    "count",
    "counted",
    "drill",
    "journey",
    "place",
    "short",
)
OF_EVERY_WAIT = {"asked", "until_at", "until", "since", "party", "points", "train"}
# by lists, whose English is a name
PLACED = {"who", "place", "seconds", "unit", "section", "kmh", *"0123456"}


def sources() -> Iterator[tuple[str, ast.Module]]:
    for path in sorted((ROOT / "study").rglob("*.py")):
        yield str(path.relative_to(ROOT)), ast.parse(path.read_text("utf-8"))


def texts_of(tree: ast.Module) -> set[str]:
    """Texts of a module that are no docstrings."""
    told = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    constants = [n for n in ast.walk(tree) if isinstance(n, ast.Constant) and id(n) not in told]
    return {node.value for node in constants if isinstance(node.value, str)}


def said_by_the_page() -> set[str]:
    """What the modules of the page say by a text of their own, found by Babel."""
    found: set[str] = set()
    for text in modules().values():
        calls = extract_javascript(BytesIO(text.encode()), {"words.say": None, "say": None}, (), {})
        found |= {m[0] if isinstance(m, tuple) else m for _, _, m, _ in calls}
    return {text for text in found if text}


def test_what_the_code_says_is_in_the_catalogue() -> None:
    calls = [node for _, tree in sources() for node in ast.walk(tree) if isinstance(node, ast.Call)]
    said = [call.args for call in calls if getattr(call.func, "id", "") == "phrase"]
    known = [[a.value for a in args] for args in said if all(isinstance(a, ast.Constant) for a in args)]  # type: ignore[attr-defined]
    assert len(known) > 300 and all(phrase(*key) for key in known)
    with pytest.raises(LookupError, match=r"ja\.po has no Japanese for 'speeed'"):
        phrase("speeed")


def test_japanese_stands_in_the_catalogue_alone() -> None:
    found = {name: {text for text in texts_of(tree) if JAPANESE.search(text)} for name, tree in sources()}
    assert {name for name, texts in found.items() if texts} == NO_LABEL
    page = "\n".join(re.sub(r"//.*|/\*[\s\S]*?\*/", "", text) for text in modules().values())
    assert [word for word in re.findall(r'"([^"\n]*)"', page) if JAPANESE.search(word)] == ["日本語"]


def test_the_catalogue_has_what_the_page_says_and_nothing_is_left_over() -> None:
    by_page, on_page = said_by_the_page(), {key.split("\u0004")[-1] for key in words_of_the_page()}
    assert len(by_page) > 80 and by_page <= on_page
    said = {text for _, tree in sources() for text in texts_of(tree)} | on_page
    template = (ROOT / "study" / "templates" / "report.html.j2").read_text("utf-8")
    entries = {english for context in OWN for english in catalogue.phrases_of(context)}
    assert {english for english in entries - said if english not in template} == set()


def test_both_languages_have_the_same_places_to_fill() -> None:
    def places(text: str) -> set[str]:
        return {name for _, name, _, _ in Formatter().parse(text) if name} - OF_EVERY_WAIT - PLACED

    phrases = [said for context in catalogue._by_context().values() for said in context.values()]
    assert [said for said in phrases if not said.ja or not places(said.ja) <= places(said.en)] == []


def test_opposites_are_said_as_the_field_says_them() -> None:
    terms = {
        "arrival": "着",
        "departure": "発",
        "down": "下り",
        "up": "上り",
        "held": "確保",
        "occupied": "在線",
        "traction": "力行",
        "regenerated": "回生",
    }
    assert {english: phrase(english).ja for english in terms} == terms
    of_pictures = {"down trains": "下り列車", "up trains": "上り列車"}
    assert {english: phrase(english, "picture").ja for english in of_pictures} == of_pictures


def test_what_the_page_shows_or_leaves_out_is_called_by_its_name() -> None:
    """Layers are drawn by their keys: another label would hide the plan for the run."""
    text = (ROOT / "study/report/web/graphpaper.js").read_text("utf-8")
    layers = dict(re.findall(r'(\w+): "([^"]+)"', text.partition("const LAYERS = {")[2].partition("};")[0]))
    assert [layers[key] for key in ("plan", "run", "sections")] == ["Plan", "Run", "Sections"]
