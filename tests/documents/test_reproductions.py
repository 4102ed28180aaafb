"""docs/reproductions.md: a row of a name is made of the reproduction's own rows."""

from dataclasses import replace

from documents.reproductions import cell_text, document, kept_of, kept_outcomes
from papers.reproduction import CaseRow, NullMethod, Reproduction
from papers.specification import REPRODUCTIONS

NULL = NullMethod("nothing", ("error, m",))
OWN = (
    CaseRow("stops", 10, 10, True, "all"),
    CaseRow("first: error, m", 0.5, 0.9, False, "at most 0.5; missed by 0.4 m: made up"),
    CaseRow("second: error, m", 0.5, 0.4, True, "at most 0.5"),
    CaseRow("the same by load", None, {"full": {"m": 0.6}}, True, "made up", judged=False),
)
WITHOUT = (
    CaseRow("first: error, m", 0.5, 3.0, False, "at most 0.5"),
    CaseRow("second: error, m", 0.5, 2.0, False, ""),
)


def made(without: tuple[CaseRow, ...] = WITHOUT) -> Reproduction:
    return Reproduction("made", "Made up", (), (*OWN, *NULL.rows(without)), null=NULL)


def test_the_case_that_leads_is_one_of_the_null_methods_that_is_met() -> None:
    found = kept_of(made())
    assert found["leads"]["case"] == "second: error, m"
    assert (found["null"]["ours"], found["null_held"]) == (2.0, True)
    assert (found["judged"], [row["case"] for row in found["missed"]]) == (3, ["first: error, m"])
    assert [row["case"] for row in found["hangs_on"]] == ["the same by load"]


def test_a_case_that_only_ends_like_that_of_the_null_method_does_not_lead() -> None:
    """As `data items at 100 km/h` ends like `100 km/h`, by which the idea is told apart."""
    null = NullMethod("nothing", ("100 km/h",))
    own = (CaseRow("items at 100 km/h", 12, 12, True, ""), CaseRow("100 km/h", None, 0.1, True, ""))
    rows = (*own, *null.rows([CaseRow("100 km/h", None, 9.0, False, "")]))
    found = kept_of(Reproduction("made", "Made up", (), rows, null=null))
    assert (found["leads"]["case"], found["null"]["ours"]) == ("100 km/h", 9.0)


def test_a_figure_of_another_case_than_the_one_that_leads_is_named() -> None:
    name = next(iter(REPRODUCTIONS))
    assert "| nothing | 2 | 2 of 3 |" in document({name: kept_of(made())})
    fewer = (CaseRow("third: error, m", None, 3.0, False, "at most 0.5"),)
    assert "| nothing | third: error, m: 3 | 2 of 3 |" in document({name: kept_of(made(fewer))})


def test_a_null_method_that_meets_the_case_is_told() -> None:
    met = (WITHOUT[0], CaseRow("second: error, m", 0.5, 0.3, True, "at most 0.5"))
    name = next(iter(REPRODUCTIONS))
    assert "meets it too" in document({name: kept_of(made(met))})
    assert "meets it too" not in document({name: kept_of(made())})


def test_where_the_idea_misses_all_cases_of_its_null_method_the_page_says_that_nothing_is_shown() -> None:
    missed = tuple(replace(row, passed=False) for row in OWN)
    found = Reproduction("made", "Made up", (), (*missed, *NULL.rows(WITHOUT)), null=NULL)
    name = next(iter(REPRODUCTIONS))
    assert "neither meets it" in document({name: kept_of(found)})
    assert "neither meets it" not in document({name: kept_of(made())})


def test_the_page_says_what_misses_and_what_it_hangs_on() -> None:
    page = document({next(iter(REPRODUCTIONS)): kept_of(made())})
    assert "- first: error, m. published: 0.5; ours: 0.9. at most 0.5; missed by 0.4 m: made up." in page
    assert "- the same by load. ours: full: (m: 0.6). made up." in page
    assert "| 2 of 3 |" in page


def test_what_is_kept_fails_without_its_idea() -> None:
    found = kept_outcomes()
    assert set(found) <= set(REPRODUCTIONS)
    assert [name for name, one in found.items() if not one["null_held"]] == []


def test_what_comes_of_a_short_slice_says_so_on_the_page() -> None:
    """A slice's figures look like those of all runs."""
    name = next(iter(REPRODUCTIONS))
    assert "| 2 of 3 (**20 of 200 runs**) |" in document(
        {name: kept_of(replace(made(), slice="20 of 200 runs"))}
    )
    assert "| 2 of 3 |" in document({name: kept_of(made())})


def test_a_cell_does_not_end_early() -> None:
    assert cell_text("a|b\nc") == r"a\|b c"
    assert cell_text({"x": 0.1234567891, "y": [1, None]}) == "x: 0.123457, y: 1, -"
