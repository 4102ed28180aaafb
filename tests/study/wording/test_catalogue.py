"""Labels stand once, in the catalogue: what code, page and pictures say is in it, and nothing else is."""

from __future__ import annotations

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
from study.wording.catalogue import phrase, phrases_of
from study.wording.phrase import Phrase

ROOT = Path(__file__).parents[3]
JAPANESE = re.compile("[ぁ-んァ-ヶ一-龠]")
# Japanese that is no label: the names of headways, which are their enum, and a sign of timetables.
NO_LABEL = {"study/capacity/headway.py", "study/plot/stations.py"}
OPPOSITES = (
    ("arrival", "departure", "着", "発"),
    ("down", "up", "下り", "上り"),
    ("traction", "regenerated", "力行", "回生"),
    ("Plan", "Run", "計画", "走行"),
    ("held", "occupied", "確保", "在線"),
)


def sources() -> Iterator[tuple[str, ast.Module]]:
    for path in sorted((ROOT / "study").rglob("*.py")):
        yield str(path.relative_to(ROOT)), ast.parse(path.read_text("utf-8"))


def texts_of(tree: ast.Module) -> Iterator[str]:
    """Texts of a module that are no docstrings."""
    told = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in told:
            yield node.value


def entries() -> dict[str, dict[str, Phrase]]:
    return {context: dict(phrases_of(context)) for context in catalogue._by_context()}


def test_what_the_code_says_is_in_the_catalogue() -> None:
    said = [
        tuple(argument.value for argument in node.args)
        for _, tree in sources()
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "phrase"
        if all(isinstance(argument, ast.Constant) for argument in node.args)
    ]
    assert len(said) > 300
    assert [key for key in said if not phrase(*key)] == []


def test_a_label_that_is_not_in_the_catalogue_is_refused() -> None:
    with pytest.raises(LookupError, match=r"ja\.po has no Japanese for 'speeed'"):
        phrase("speeed")


def said_by_the_page() -> set[str]:
    """What the modules of the page say by a text of their own, found by Babel."""
    found: set[str] = set()
    for text in modules().values():
        calls = extract_javascript(BytesIO(text.encode()), {"words.say": None, "say": None}, (), {})
        found |= {m[0] if isinstance(m, tuple) else m for _, _, m, _ in calls}
    return {text for text in found if text}


def test_what_the_page_says_is_in_the_catalogue() -> None:
    known = {key.split("\u0004")[-1] for key in words_of_the_page()}
    said = said_by_the_page()
    assert len(said) > 80
    assert said - known == set()


def test_japanese_stands_in_the_catalogue_alone() -> None:
    found = {
        name: [text for text in texts_of(tree) if JAPANESE.search(text)]
        for name, tree in sources()
        if name not in NO_LABEL
    }
    assert {name: texts for name, texts in found.items() if texts} == {}
    page = "\n".join(re.sub(r"//.*|/\*[\s\S]*?\*/", "", text) for text in modules().values())
    assert [word for word in re.findall(r'"([^"\n]*)"', page) if JAPANESE.search(word)] == ["日本語"]


def test_nothing_in_the_catalogue_is_left_over() -> None:
    """Lists of a context are held against their enums elsewhere; all others are said by code, template or page."""
    lists = {
        *("event", "event kind", "fault", "fault figure", "act", "tag", "points", "reader", "rule", "danger"),
        *(
            "ending",
            "cause",
            "part",
            "drawn",
            "telegram",
            "party",
            "reason",
            "assumption",
            "opinion",
            "picture",
        ),
        "expected",
    }
    said = {text for _, tree in sources() for text in texts_of(tree)} | said_by_the_page()
    template = (ROOT / "study" / "templates" / "report.html.j2").read_text("utf-8")
    said |= {key.split("\u0004")[-1] for key in words_of_the_page()}
    left = [
        (context, english)
        for context, all_of_it in entries().items()
        for english in all_of_it
        if context not in lists and english not in said and english not in template
    ]
    assert left == []


@pytest.mark.parametrize("context", catalogue._by_context())
def test_both_languages_have_the_same_places_to_fill(context: str) -> None:
    def places(text: str) -> set[str]:
        return {name for _, name, _, _ in Formatter().parse(text) if name}

    for said in entries()[context].values():
        assert said.ja and places(said.ja) <= places(said.en) | KNOWN_TO_ALL, said


KNOWN_TO_ALL = {
    *("who", "place", "seconds", "unit", "section", "kmh", "0", "1", "2", "3", "4", "5"),  # of lists of forms
    *("asked", "until_at", "until", "since", "party", "points", "train"),  # of every wait
}


@pytest.mark.parametrize(("one", "other", "one_ja", "other_ja"), OPPOSITES)
def test_opposites_are_said_as_the_field_says_them(one: str, other: str, one_ja: str, other_ja: str) -> None:
    assert [phrase(one).ja, phrase(other).ja] == [one_ja, other_ja]
