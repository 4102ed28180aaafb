"""The page's modules, run by Node where there is one: they are plain ES modules and need no browser."""

import subprocess
from pathlib import Path
from shutil import which

import pytest

TESTS = (
    Path(__file__).parent / "web" / "modules.test.mjs",
    Path(__file__).parents[2] / "console" / "web" / "wire.test.mjs",  # of the desk's pages
)


@pytest.mark.skipif(which("node") is None, reason="no Node on this machine, which runs the page's modules")
def test_modules_do_what_their_tests_say() -> None:
    ended = subprocess.run(
        ["node", "--test", *map(str, TESTS)], capture_output=True, text=True, check=False, timeout=300
    )
    assert ended.returncode == 0, ended.stdout[-6000:]
