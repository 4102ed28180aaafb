"""A file of a user's in the place of one of the packages is named, in one line."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from branchline.hidden import PACKAGES
from documents.structure import ROOT

IN_PYTHON = ("-c", "import branchline; branchline.load('rtri_test_line')")
AS_COMMAND = ("-m", "branchline", "schema")


@pytest.mark.parametrize(
    ("hiding", "start", "code"),
    [
        ("network.py", AS_COMMAND, 2),
        ("study/__init__.py", IN_PYTHON, 1),
        pytest.param("simulation/notes.txt", AS_COMMAND, 2, marks=pytest.mark.nightly),
    ],
)
def test_what_hides_a_package_is_named(
    tmp_path: Path, hiding: str, start: tuple[str, ...], code: int
) -> None:
    file = tmp_path / hiding
    file.parent.mkdir(exist_ok=True)
    file.write_text("", "utf-8")
    done = subprocess.run([sys.executable, *start], cwd=tmp_path, capture_output=True, text=True, check=False)
    told = done.stderr.splitlines()[-1]
    assert done.returncode == code
    named = file if file.suffix == ".py" else file.parent
    assert f"{named} hides the package {hiding.partition('/')[0].removesuffix('.py')!r}" in told
    assert (len(done.stderr.splitlines()) == 1) is (start is AS_COMMAND)


def test_a_folder_of_other_files_hides_nothing(tmp_path: Path) -> None:
    (tmp_path / "networks.py").touch()
    done = subprocess.run([sys.executable, *AS_COMMAND], cwd=tmp_path, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


def test_every_package_that_is_installed_is_looked_for() -> None:
    tables = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    found = {name for name in tables["tool"]["setuptools"]["packages"]["find"]["include"] if "." not in name}
    assert set(PACKAGES) == found - {"branchline", "documents"}  # which no command or verb imports
