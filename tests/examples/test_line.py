"""The line of docs/make-a.md, as a newcomer would use it: files beside one another, nothing shipped but a train."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from network.files.line_file import load_line
from network.tag_layout import lay_tags, tags_toml

HERE = Path(__file__).parent / "line"
RECIPE = (Path(__file__).resolve().parents[2] / "docs/make-a.md").read_text("utf-8")
FILES = ("valley.toml", "valley_times.toml", "valley_day.toml")


def test_the_recipe_names_every_file_of_the_example_and_no_other() -> None:
    line = RECIPE.partition("## … line")[2].partition("\n## ")[0]
    assert {path.name for path in HERE.iterdir()} == set(FILES)
    assert set(re.findall(r"\*\*`(\w+\.toml)`", line)) == set(FILES)


def test_its_tags_are_those_that_the_rule_prints() -> None:
    line = load_line(HERE / "valley.toml")
    assert tags_toml(line, lay_tags(line)) in (HERE / "valley.toml").read_text("utf-8")


def test_it_runs_on_sumo_and_the_trains_pass_at_the_loop(main: Callable[..., Any], tmp_path: Path) -> None:
    for name in FILES:
        shutil.copy(HERE / name, tmp_path / name)
    checked = main("check", "valley_day.toml", "--json").figures()
    assert (checked["trains"], checked["findings"]) == (2, [])
    assert [(meet["station"], meet["tracks"]) for meet in checked["meets"]] == [("MRI", ["1", "2"])]
    ended = main("run", "valley_day.toml", "--json", "--out", "out")
    figures = ended.figures()
    assert ended.code == 0
    assert figures["trains_arrived"] == figures["trains_planned"] == 2
    assert figures["invariants_broken"] == figures["collisions"] == 0
    assert figures["late_s_max"] < 30.0  # 4 min for 3 km at 70 km/h leave room
    assert figures["changes"] == []
    assert (tmp_path / "out/report.html").is_file()
