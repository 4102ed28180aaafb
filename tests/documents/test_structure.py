from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from documents.structure import ROOT, imports_rule, kernel_files, lengths_rule, parameters_rule, unit_rule
from documents.structure_rule import LAYERS, PRODUCT

CONTRACT = "[[tool.importlinter.contracts]]\n"
LAW = """
from vehicle.compiled import compiled
from vehicle.mass import weigh


@compiled
def advance(a, b, c, d, e, f, g{more}): ...
"""


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A project of three files: the kernel, what it imports, and a file that is no part of it."""
    for name in ("simulation/world/kernel.py", "vehicle/mass.py", "vehicle/other.py", "onboard/unit.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("")
    (tmp_path / "simulation/world/kernel.py").write_text(LAW.format(more=", h"))
    return tmp_path


def test_the_kernel_is_what_its_loop_imports() -> None:
    files = {file.relative_to(ROOT).as_posix() for file in kernel_files(ROOT)}
    assert {"onboard/tick.py", "vehicle/dynamics.py", "onboard/driving/tasc.py"} <= files
    assert "simulation/sensors/camera_pixels.py" not in files


def test_nine_parameters_are_too_many_in_the_kernel_and_in_what_it_imports(tree: Path) -> None:
    assert parameters_rule(tree).broken == ()
    (tree / "vehicle/other.py").write_text(LAW.format(more=", h, i"))
    assert parameters_rule(tree).broken == ()
    (tree / "vehicle/mass.py").write_text(LAW.format(more=", h, *, i"))
    assert parameters_rule(tree).broken == ("vehicle/mass.py: advance takes 9",)


def test_a_file_is_too_long_from_the_first_line_beyond(tree: Path) -> None:
    (tree / "onboard/unit.py").write_text("a = 1\n" * 12)
    assert lengths_rule(tree, 12).broken == ()
    assert lengths_rule(tree, 11).broken == ("onboard/unit.py has 12 lines",)
    assert unit_rule(tree, 13).broken == ()
    assert unit_rule(tree, 12).broken == ("onboard/unit.py has 12 lines",)


def test_an_import_that_runs_back_is_found(tmp_path: Path) -> None:
    """In a project of two packages whose contract the lower one breaks."""
    for package in ("upper", "lower"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").write_text("")
    contract = f"{CONTRACT}name = 'one way'\ntype = 'layers'\nlayers = ['upper', 'lower']\n"
    roots = "[tool.importlinter]\nroot_packages = ['upper', 'lower']\n"
    (tmp_path / "pyproject.toml").write_text(roots + contract)
    assert imports_rule(tmp_path).broken == ()
    (tmp_path / "lower" / "thing.py").write_text("import upper\n")
    assert imports_rule(tmp_path).broken == ("one way BROKEN",)


@pytest.mark.parametrize(
    "import_back",
    [
        "from network.route import Route\n",
        "from network import route\n",
        "import network.route\n",
        "if TYPE_CHECKING:\n    from network.route import Route\n",
        "def later() -> None:\n    from network.route import Route\n",
    ],
)
def test_a_circle_is_found_wherever_the_import_that_closes_it_stands(
    tmp_path: Path, import_back: str
) -> None:
    """By the contract of the project's own pyproject.toml, which is of all packages, here over one of two files."""
    linter = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    (circles,) = (one for one in linter["contracts"] if one["type"] == "acyclic_siblings")
    assert tuple(circles["ancestors"]) == PRODUCT
    (tmp_path / "pyproject.toml").write_text(
        f"[tool.importlinter]\nroot_packages = ['network']\n{CONTRACT}name = 'circles'\n"
        f"type = '{circles['type']}'\nancestors = ['network']\n"
    )
    (tmp_path / "network").mkdir()
    (tmp_path / "network/__init__.py").write_text("")
    (tmp_path / "network/route.py").write_text(
        "from network.graph import Graph\n\n\nclass Route(Graph): ...\n"
    )
    graph = tmp_path / "network/graph.py"
    graph.write_text("from typing import TYPE_CHECKING\n\n\nclass Graph: ...\n")
    assert imports_rule(tmp_path).broken == ()
    graph.write_text(graph.read_text() + import_back)
    assert imports_rule(tmp_path).broken == ("circles BROKEN",)


def test_docs_architecture_has_every_package_and_the_order_of_the_contract() -> None:
    page = (ROOT / "docs/architecture.md").read_text("utf-8")
    assert set(re.findall(r"^\| `(\w+)/` \|", page, re.MULTILINE)) == set(PRODUCT)
    order = " > ".join(f"({layer})" if "|" in layer else layer for layer in LAYERS)
    assert f"`{order}`" in page
