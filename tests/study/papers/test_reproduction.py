"""Every reproduction of `branchline reproduce list` has a null method, and passes only where that one fails."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import pytest

from study.papers.reproduction import REPRODUCTIONS, NullMethod, Reproduction, Row

NULL = NullMethod("nothing at all", ("error, m",))
FOUND = Row("line 1: error, m", 1.0, 0.9, passed=True, criterion="at most 1")
MISSED = replace(FOUND, ours=7.0, passed=False)


def made(*rows: Row, null: NullMethod = NULL) -> Reproduction:
    return Reproduction("made", "Made up", (), rows, null=null)


@pytest.mark.parametrize("name", sorted(REPRODUCTIONS))
def test_every_reproduction_names_its_null_method(name: str) -> None:
    null = import_module(REPRODUCTIONS[name]).NULL
    assert isinstance(null, NullMethod)
    assert null.name
    assert null.fails
    assert all(null.fails)


def test_the_row_of_a_null_method_passes_where_it_misses_the_criterion() -> None:
    (row,) = NULL.rows([MISSED, replace(MISSED, case="another, s")])
    assert row.case == "null method, nothing at all: line 1: error, m"
    assert row.criterion == "must not be met: at most 1"
    assert (row.ours, row.passed) == (7.0, True)
    assert made(FOUND, row).passed
    assert made(FOUND, row).as_dict()["null_method"] == NULL.name


def test_what_is_met_without_the_idea_is_not_reproduced() -> None:
    assert not made(FOUND, *NULL.rows([FOUND])).passed


@pytest.mark.parametrize(
    "null",
    [
        NULL,
        NullMethod(NULL.name, ()),
        NullMethod(NULL.name, ("error, m", "another, s")),
        NullMethod("another", NULL.fails),
    ],
)
def test_without_the_null_methods_rows_it_is_refused(null: NullMethod) -> None:
    rows = () if null is NULL else NULL.rows([MISSED])
    with pytest.raises(ValueError, match="null method"):
        made(FOUND, *rows, null=null)
