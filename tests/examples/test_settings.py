"""The recipe "a table of settings" of docs/make-a.md, followed: a class and a field, and all else knows the table."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

SCENARIO = """
extends = "rtri_test_line"
id = "s"
name = "With a table of its own"
patience.wait_s = {wait}
{rest}
"""
READ = """
import json, sys
from scenario.scenario import load_scenario
loaded = load_scenario("s.toml")
told = [[change.key, change.old, change.new] for change in loaded.inputs.changes]
print(json.dumps({"wait_s": loaded.setup.patience.wait_s, "changes": told}))
"""


def test_two_files_make_a_table_that_files_patches_schema_and_page_know(clone: Callable[[], Any]) -> None:
    made = clone()
    made.follow("table of settings")
    assert made.is_what_is_told("table of settings")
    assert len(made.touched) == 2
    made.holds("tests/documents/test_files.py", "tests/scenario/test_key_examples.py")
    assert "\n## `[patience]`\n" in (made.root / "docs/files/scenario.md").read_text("utf-8")
    schema = json.loads(made.python("-m", "branchline.cli", "schema", "scenario").stdout)
    assert schema["$defs"]["WaitSettings"]["properties"]["wait_s"]["examples"] == [600.0]
    written(made.root, "60.0", "[patch.patience]\ntimes = { wait_s = 2.0 }")
    done = made.python("-c", READ)
    assert json.loads(done.stdout) == {
        "wait_s": 120.0,
        "changes": [["patience.wait_s", 600.0, 120.0]],
    }
    written(made.root, "-1.0", "")
    refused = made.python("-m", "branchline.cli", "check", "s.toml")
    assert refused.returncode == 2
    assert all(text in refused.stderr for text in ("s.toml", "patience.wait_s", "-1.0", "0 to 3600"))


def written(root: Path, wait: str, rest: str) -> None:
    (root / "s.toml").write_text(SCENARIO.format(wait=wait, rest=rest), "utf-8")
