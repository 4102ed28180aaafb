"""What docs/glossary.md says is defined somewhere is defined there, and no term is explained twice."""

import ast
import re
from collections.abc import Iterator

import pytest

from documents.structure import ROOT

PAGE = ROOT / "docs" / "glossary.md"
COLUMNS = ("term", "Japanese", "meaning", "defined in")


def rows() -> Iterator[list[str]]:
    for line in PAGE.read_text("utf-8").splitlines():
        if line.startswith("|") and not line.startswith("|---"):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            assert len(cells) == len(COLUMNS), line
            if cells != list(COLUMNS):
                yield cells


def is_defined(name: str) -> bool:
    """A module, or what a module defines at its top."""
    path = ROOT.joinpath(*name.split("."))
    if path.with_suffix(".py").exists() or (path / "__init__.py").exists():
        return True
    module = path.parent.with_suffix(".py")
    if not module.exists():
        return False
    top = ast.parse(module.read_text("utf-8")).body
    return path.name in {node.name for node in top if isinstance(node, ast.ClassDef | ast.FunctionDef)}


@pytest.mark.parametrize("name", sorted({n for *_, where in rows() for n in re.findall(r"`([^`]+)`", where)}))
def test_what_the_glossary_names_is_there(name: str) -> None:
    assert is_defined(name), f"{PAGE.name} says `{name}`, which is not there"


@pytest.mark.parametrize("name", ["network.model.Siding", "network.sidings", "sidings.model.Line"])
def test_what_is_not_there_is_noticed(name: str) -> None:
    assert not is_defined(name)


def test_each_term_stands_once_with_a_meaning_and_a_place() -> None:
    terms = [term for term, *_ in rows()]
    assert len(terms) == len(set(terms)) > 60
    assert all(meaning and where.startswith("`") for _, _, meaning, where in rows())


def test_terms_of_the_papers_are_in_it() -> None:
    japanese = " ".join(word for _, word, *_ in rows())
    assert all(
        word in japanese for word in ("閉そく", "転てつ機", "続行", "行違い", "鎖錠", "停止限界点", "地上子")
    )
