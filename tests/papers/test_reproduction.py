"""Every reproduction of `branchline reproduce list` has a null method, and passes only where that one fails."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from network.errors import InputError
from papers.parameter_sets import NotDriven
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, Reproduction
from papers.specification import (
    REPRODUCTIONS,
    Evenly,
    Findings,
    Specification,
    at_most,
    equal_figure,
    none_of,
    reported_figure,
    reproduction,
)

NULL = NullMethod("nothing at all", ("error, m",))
FOUND = CaseRow("line 1: error, m", 1.0, 0.9, passed=True, criterion="at most 1")
MISSED = replace(FOUND, ours=7.0, passed=False)


def made(*rows: CaseRow, null: NullMethod = NULL) -> Reproduction:
    return Reproduction("made", "Made up", (), rows, null=null)


@pytest.mark.parametrize("name", sorted(REPRODUCTIONS))
def test_every_reproduction_names_its_null_method(name: str) -> None:
    found = reproduction(name)
    assert found.name == name
    assert found.null.name
    assert found.null.fails
    assert all(found.null.fails)


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


def a_run(_options: Options) -> Findings:
    return Findings([FOUND], remarks=["said"], draw=lambda folder: [folder / "made.svg"])


@pytest.mark.parametrize(("null_m", "passed"), [(7.0, True), (0.5, False)])
def test_a_specification_runs_its_null_method_and_passes_only_where_that_one_fails(
    null_m: float, passed: bool
) -> None:
    null = replace(NULL, run=lambda _options: [at_most(FOUND.case, None, null_m, 1.0)])
    made_up = Specification("made", "Made up", a_run, null, NotDriven("said"), slice="short")
    result = made_up(Options(out="somewhere", quick=True))
    assert [row.passed for row in result.rows] == [True, passed]
    assert result.remarks == ("said", "drawn: made.svg", "short")
    assert (result.slice, made_up(Options()).slice) == ("short", "")
    assert result.parameters == (Parameter("parameter set", "none", "", "said"),)
    assert made_up(Options()).remarks == ("said",)


@pytest.mark.parametrize("quick", [True, False])
def test_a_criterion_that_is_of_the_whole_is_told_of_a_slice_and_not_judged(quick: bool) -> None:
    null = replace(NULL, run=lambda _options: [at_most(FOUND.case, None, 7.0, 1.0)])
    made_up = Specification(
        "made",
        "Made up",
        lambda _options: Findings([MISSED, FOUND]),
        null,
        NotDriven("said"),
        slice="short",
        whole=(MISSED.case,),
    )
    row, *_ = made_up(Options(quick=quick)).rows
    assert (row.judged, row.passed) == (not quick, quick)
    assert row.criterion == ("of all runs, not judged of some: " if quick else "") + MISSED.criterion


@pytest.mark.parametrize("name", REPRODUCTIONS)
def test_what_leaves_runs_out_says_which(name: str) -> None:
    """Else what comes of it would count as the whole."""
    found = reproduction(name)
    source = Path(str(sys.modules[f"papers.{name.replace('-', '_')}"].__file__)).read_text("utf-8")
    assert bool(found.slice) == (".quick" in source)


def test_rows_of_a_kind_say_what_they_ask_for() -> None:
    assert at_most("far, m", None, 1.23456, 1.3, digits=2) == CaseRow(
        "far, m", None, 1.23, True, "at most 1.3"
    )
    assert not at_most("far, m", None, 1.300001, 1.3).passed
    assert [none_of("lost", count).passed for count in (0, 1)] == [True, False]
    assert [equal_figure("items", 12, count).passed for count in (12, 11)] == [True, False]
    told = reported_figure("width", 3, "told")
    assert (told.criterion.endswith("not judged"), told.judged) == (True, False)


def test_what_is_drawn_evenly_is_what_is_printed() -> None:
    within = Evenly("lag", 0.2, 0.4, "s", "assumed")
    drawn = [within.draw(np.random.default_rng(seed)) for seed in range(200)]
    assert 0.2 <= min(drawn) < 0.21
    assert 0.39 < max(drawn) <= 0.4
    assert within.at(np.array([0.0, 0.5, 1.0])) == pytest.approx([0.2, 0.3, 0.4])
    assert within.parameter == Parameter("lag", "0.2 to 0.4", "s", "assumed")


def test_where_nothing_can_be_drawn_nothing_is_run(tmp_path: Path) -> None:
    """And an experiment that fails leaves no folder behind."""
    made_up = Specification("made", "Made up", lambda _: 1 / 0, NULL, NotDriven("nothing moves"))  # type: ignore[arg-type,return-value]
    (tmp_path / "taken").write_text("mine", "utf-8")
    with pytest.raises(InputError, match=r"--out is '.*taken'; expected a directory that can be written"):
        made_up(Options(out=str(tmp_path / "taken")))
    with pytest.raises(ZeroDivisionError):
        made_up(Options(out=str(tmp_path / "a" / "b")))
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]
