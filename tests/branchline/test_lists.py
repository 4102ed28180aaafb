"""What a command lists is its result: it stands on stdout, and stderr stays empty."""

from collections.abc import Callable
from typing import Any

import pytest

from papers.specification import REPRODUCTIONS
from scenario.schemas import KINDS
from study.drilling.drill import shipped_drills


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (("reproduce", "list"), sorted(REPRODUCTIONS)),
        (("drill", "list"), shipped_drills()),
        (("schema",), KINDS),
    ],
)
@pytest.mark.parametrize("form", [(), ("--json",)])
def test_a_list_stands_on_stdout(
    main: Callable[..., Any], arguments: tuple[str, ...], names: tuple[str, ...], form: tuple[str, ...]
) -> None:
    if arguments[0] == "schema" and form:
        return  # it is JSON anyway
    ended = main(*arguments, *form)
    assert (ended.code, ended.err) == (0, "")
    for name in names:
        assert name in ended.out
    if form:
        assert ended.figures()
