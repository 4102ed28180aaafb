"""Each count on a made tree of two files: it holds, is broken by one edit, and asks for what was mended to be told."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from documents.counted import (
    KEPT,
    UNSAID,
    Ceilings,
    class_names_rule,
    field_lists_rule,
    sizes_rule,
    slices_rule,
    trees,
)

NONE = Ceilings(frozenset(), product_lines=20, test_lines=1, pairs=0)
RECORD = "class {name}:\n    a: int\n    b: int\n    c: int\n    d: int\n    e: int\n    {last}: int\n"


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A product of 20 lines, and a test of one."""
    files = {
        "network/graph.py": "from typing import TYPE_CHECKING\n\n\n\n\n\n"
        + RECORD.format(name="Graph", last="f"),
        "network/route.py": "from network.graph import Graph\n\n\nclass Route(Graph): ...\n\n\n",
        "papers/curve.py": "\n",
        "tests/test_graph.py": "\n",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_a_class_name_taken_twice_is_found_in_whatever_package(tree: Path) -> None:
    assert class_names_rule(trees(tree), frozenset()).broken == ()
    (tree / "papers/curve.py").write_text("class Route: ...\n")
    (found,) = class_names_rule(trees(tree), frozenset()).broken
    assert found.startswith(
        "Route in network/route.py:4, papers/curve.py:1: one class where both mean the same"
    )
    assert class_names_rule(trees(tree), frozenset({"Route"})).broken == ()


def test_a_name_that_is_unique_by_now_must_leave_the_list(tree: Path) -> None:
    (found,) = class_names_rule(trees(tree), frozenset({"Route"})).broken
    assert found == "Route: mended, take it out of `class_names` in ceilings.toml"


def test_figures_of_a_slice_are_refused_and_so_are_those_that_do_not_say(tree: Path) -> None:
    assert slices_rule(tree, frozenset()).broken == ()
    kept = {"all": {"slice": ""}, "short": {"slice": "20 of 200 runs"}, "old": {"title": "Made up"}}
    (tree / KEPT).parent.mkdir()
    (tree / KEPT).write_text(json.dumps(kept), "utf-8")
    old, short = slices_rule(tree, frozenset()).broken
    assert old == f"old: {UNSAID}; `make reproductions NAMES=old`"
    assert short == "short: 20 of 200 runs; `make reproductions NAMES=short`"
    assert slices_rule(tree, frozenset({"old", "short"})).broken == ()
    (gone,) = slices_rule(tree, frozenset({"all", "old", "short"})).broken
    assert gone == "all: mended, take it out of `slices` in ceilings.toml"


def test_lines_beyond_the_ceiling_and_a_ceiling_far_above_the_lines_are_both_told(tree: Path) -> None:
    assert sizes_rule(tree, NONE).broken == ()
    (more,) = sizes_rule(tree, replace(NONE, product_lines=19)).broken
    assert more.startswith("20 lines of the product, 19 were there")
    (lower,) = sizes_rule(tree, replace(NONE, test_lines=2)).broken
    assert lower == "1 lines of the tests: lower `test_lines` in ceilings.toml from 2 to that"


def test_a_room_above_the_simulation_has_its_share(tree: Path) -> None:
    """Three lines of 22 are within 15 %, four of 23 are not; nothing below the simulation is bounded."""
    (tree / "papers/curve.py").write_text("\n" * 3)
    assert not [text for text in sizes_rule(tree, NONE).broken if "divide" in text]
    (tree / "papers/curve.py").write_text("\n" * 4)
    assert any(
        text.startswith("papers has 4 lines of 23: divide it") for text in sizes_rule(tree, NONE).broken
    )


def test_rooms_of_the_study_are_counted_apart(tree: Path) -> None:
    for room in ("plot", "report"):
        (tree / "study" / room).mkdir(parents=True)
        (tree / "study" / room / "page.py").write_text("\n" * 3)
    assert not [text for text in sizes_rule(tree, NONE).broken if "divide" in text]


def test_six_fields_of_one_class_in_a_row_in_another_are_a_restated_list(tree: Path) -> None:
    assert field_lists_rule(trees(tree), 0).broken == ()
    curve = tree / "papers/curve.py"
    curve.write_text(RECORD.format(name="Curve", last="other"))
    assert field_lists_rule(trees(tree), 0).broken == ()
    curve.write_text(RECORD.format(name="Curve", last="f"))
    count, pair = field_lists_rule(trees(tree), 0).broken
    assert count.startswith("1 pairs of restated lists of fields, 0 were there")
    assert pair.startswith("network/graph.py:7 and papers/curve.py:1: hand the record on")
    assert field_lists_rule(trees(tree), 1).broken == ()


def test_a_call_that_names_the_fields_of_a_class_restates_them(tree: Path) -> None:
    (tree / "papers/curve.py").write_text("drawn(z=0, a=1, b=2, c=3, d=4, e=5, f=6)\n")
    assert len(field_lists_rule(trees(tree), 0).broken) == 2
    (tree / "papers/curve.py").write_text("drawn(a=1, b=2, c=3, z=0, d=4, e=5, f=6)\n")
    assert field_lists_rule(trees(tree), 0).broken == ()


def test_a_call_that_makes_a_class_is_how_its_fields_are_given(tree: Path) -> None:
    """Also twice, by another module's name or one that derives; not where a class of another name is made."""
    fields = "(a=1, b=2, c=3, d=4, e=5, f=6)\n"
    curve = tree / "papers/curve.py"
    curve.write_text(f"Graph{fields}graph.Graph{fields}Graph[int]{fields}")
    assert field_lists_rule(trees(tree), 0).broken == ()
    curve.write_text(f"Route{fields}")  # derives from Graph
    assert field_lists_rule(trees(tree), 0).broken == ()
    curve.write_text(f"class Curve: ...\nCurve{fields}")
    assert len(field_lists_rule(trees(tree), 0).broken) == 2
    curve.write_text(f"class Curve(Graph): ...\nCurve{fields}Route{fields}")
    count, pair = field_lists_rule(trees(tree), 0).broken
    assert count.startswith("1 pairs")
    assert pair.startswith("papers/curve.py:2 and papers/curve.py:3")


def test_a_class_that_repeats_the_fields_of_its_base_restates_them(tree: Path) -> None:
    (tree / "papers/curve.py").write_text(RECORD.format(name="Curve(Graph)", last="f"))
    assert len(field_lists_rule(trees(tree), 0).broken) == 2
