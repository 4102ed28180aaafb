"""What is explored to compare runs with is explored once for a code, and what is being done is said."""

from pathlib import Path

import pytest

from network.code_store import CodeStore
from verify.evidence import inside_runs
from verify.evidence.inside_runs import explored_views
from verify.explored_line import ExploredLine


def test_a_line_is_explored_once_for_a_code_and_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store, said = CodeStore(tmp_path), list[str]()
    first = explored_views((ExploredLine(),), said.append, store)
    assert said[0] == "exploring line 1 of 1, once for this code (0/0/0/0/0/0/0)"
    assert ": level 50, " in said[5]
    monkeypatch.delattr(inside_runs, "explored")  # from now on nothing can be
    assert explored_views((ExploredLine(),), said.append, store) == first
    with pytest.raises(NameError, match="explored"):
        explored_views((ExploredLine(timed=True),), said.append, store)
    monkeypatch.setattr(inside_runs, "DECIDING", (*inside_runs.DECIDING, "host"))
    with pytest.raises(NameError, match="explored"):
        explored_views((ExploredLine(),), said.append, store)
