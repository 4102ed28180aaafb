"""The wheel, with compiled code inside: one for each minor version of Python and each platform.

    python -m documents.wheel [FOLDER]

builds it into FOLDER, `dist` if none is named. The tree is copied first, so that nothing of it changes.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from documents.structure import PACKAGES, ROOT
from vehicle.compiled import SHIPPED

COPIED: Final = ("pyproject.toml", "README.md", "LICENSE")
ANY_PROCESSOR: Final = "generic"


def compile_into(folder: Path, names: Sequence[str] = ()) -> None:
    """Compile what these days need, or all of `DAYS`, for any processor; it lies in `machine_code` there."""
    here = {"NUMBA_CACHE_DIR": str(folder), "NUMBA_CPU_NAME": ANY_PROCESSOR, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "documents.machine_code", *names]
    subprocess.run(command, cwd=folder, env=os.environ | here, check=True, stdout=sys.stderr)


def build_wheel(folder: Path, names: Sequence[str] = ()) -> Path:
    """Build the wheel into a folder; `names` as in `compile_into`. CalledProcessError where pip fails."""
    python = "cp{}{}".format(*sys.version_info)
    tags = f"--build-option=--python-tag={python} --plat-name={sysconfig.get_platform()}"
    with tempfile.TemporaryDirectory() as scratch:
        tree = Path(scratch)
        made = shutil.ignore_patterns("__pycache__", SHIPPED.name)
        for name in PACKAGES:
            if name != "tests":
                shutil.copytree(ROOT / name, tree / name, ignore=made)
        for name in COPIED:
            shutil.copy(ROOT / name, tree)
        compile_into(tree / SHIPPED.parent.name, names)
        pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--disable-pip-version-check", "--no-deps"]
        subprocess.run([*pip, "--wheel-dir", str(folder), "--config-settings", tags, str(tree)], check=True)
    (wheel,) = folder.glob(f"branchline-*-{python}-none-*.whl")
    return wheel


if __name__ == "__main__":
    sys.stdout.write(f"{build_wheel(Path(*sys.argv[1:2] or ['dist']))}\n")
