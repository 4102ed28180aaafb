"""docs/notebooks: every cell runs, and shows what is committed."""

from pathlib import Path

import pytest
from nbclient.exceptions import CellExecutionError

from documents.notebooks import FOLDER, QUICK, execute_notebook, notebook, texts_shown
from documents.structure import ROOT

LONG = "DAYS = 1000"


@pytest.fixture(autouse=True)
def _this_tree(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))


@pytest.mark.nightly
@pytest.mark.parametrize("name", QUICK)
def test_a_notebook_shows_what_is_committed(tmp_path: Path, name: str) -> None:
    book = notebook(name)
    committed = texts_shown(book)
    execute_notebook(book, tmp_path)
    assert texts_shown(book) == committed
    assert any(committed)


def test_a_cell_that_fails_is_an_error(tmp_path: Path) -> None:
    book = notebook("thousand-days")
    cells = [cell for cell in book["cells"] if cell["cell_type"] == "code"]
    cells[0]["source"] = "1 / 0"
    with pytest.raises(CellExecutionError, match="ZeroDivisionError"):
        execute_notebook(book, tmp_path)


@pytest.mark.nightly
def test_a_few_of_the_thousand_days(tmp_path: Path) -> None:
    book = notebook("thousand-days")
    (days,) = [cell for cell in book["cells"] if cell["source"] == LONG]
    days["source"] = "DAYS = 3"
    execute_notebook(book, tmp_path)
    assert "True" in texts_shown(book)[1]
    assert len(list(tmp_path.rglob("days.csv"))) == 1


def test_every_notebook_is_run_by_a_test() -> None:
    assert {file.stem for file in FOLDER.glob("*.ipynb")} == {*QUICK, "thousand-days"}
