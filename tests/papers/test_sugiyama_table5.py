"""Table 5 of Sugiyama, Fukuda and Kitano (2017): complete, on both lines, and met on the test line."""

import pytest

from papers.reproduction import Options
from papers.sugiyama_table5 import LINES, NULL_DRILLS, TABLE5, drills_of, reproduce

# as counted in table 5: no failure 3, on-board 4, tachometer 1, manager 2, terminal 2 ("cut / power off"), tag 1;
# and from table 2: manager and on-board units together
ROWS = 3 + 4 + 1 + 2 + 2 + 1 + 1


def test_the_table_has_the_papers_rows_in_order() -> None:
    assert [reaction.row for reaction in TABLE5] == list(range(1, ROWS + 1))


@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("row", range(1, ROWS + 1))
def test_every_row_has_its_drill_on_every_line(line: str, row: int) -> None:
    assert drills_of(row, line)


@pytest.mark.parametrize("line", LINES)
def test_the_tachometer_fails_both_ways_and_the_tag_variant_is_there(line: str) -> None:
    assert len(drills_of(8, line)) >= 2  # 出力異常・出力なし
    assert f"{line}/05b_extra_tag" in drills_of(5, line)  # table 3's note


@pytest.mark.parametrize("line", LINES)
def test_manager_and_units_fail_together_in_stations_on_the_open_line_and_one_each(line: str) -> None:
    assert [name.split("manager_and_units_")[1] for name in drills_of(14, line)] == [
        "in_stations",
        "on_open_line",
        "one_each",
    ]


@pytest.mark.nightly
def test_all_rows_are_met_on_the_test_line() -> None:
    result = reproduce(Options(quick=True))
    assert [row.case for row in result.rows if not row.passed] == []
    own = [row.case for row in result.rows if row.case.startswith("row ")]
    assert len(result.rows) == len(own) + len(NULL_DRILLS)
    assert {int(case.split(",")[0].removeprefix("row ")) for case in own} == set(range(1, ROWS + 1))
    assert any("quick" in remark for remark in result.remarks)
