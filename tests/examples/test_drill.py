"""The drill of docs/make-a.md, as it stands there: every expectation is met, and the contrary of the first is not."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.examples.conftest import recipe


@pytest.mark.parametrize(("was", "written", "code"), [("", "", 0), ("absent = true\n", "", 1)])
def test_the_drill_of_the_recipe(main: Callable[..., Any], was: str, written: str, code: int) -> None:
    (text,) = re.findall(r"```toml\n(.*?)```", recipe("drill"), re.DOTALL)
    assert was in text
    Path("terminal_hangs.toml").write_text(text.replace(was, written), "utf-8")
    ended = main("drill", "terminal_hangs.toml", "--out", "out")
    assert ended.code == code, ended.out + ended.err
    assert Path("out/report.html").is_file()
