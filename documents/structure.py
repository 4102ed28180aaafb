"""What holds the structure together, counted: imports, parameters of compiled functions, lengths of files,
and what `documents.counted` counts.

`python -m documents.structure` prints each rule with its figure and ends with 1 where one is broken.
"""

from __future__ import annotations

import argparse
import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from documents.counted import ceilings, rules
from documents.structure_rule import PRODUCT, TESTS, StructureRule

ROOT: Final = Path(__file__).resolve().parent.parent
PACKAGES: Final = (*PRODUCT, TESTS)
UNIT: Final = Path("onboard/unit.py")
KERNEL: Final = Path("simulation/world/kernel.py")
PARAMETERS_MAX: Final = 8


def sources(root: Path) -> Iterator[Path]:
    """Every Python file of the project."""
    for package in PACKAGES:
        yield from sorted((root / package).rglob("*.py"))


def compiled_parameters(file: Path) -> Iterator[tuple[str, int]]:
    """Name and number of parameters of each function that the file compiles."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.FunctionDef):
            names = [d.id for d in node.decorator_list if isinstance(d, ast.Name)]
            if "compiled" in names:
                taken = node.args
                yield node.name, len(taken.posonlyargs) + len(taken.args) + len(taken.kwonlyargs)


def kernel_files(root: Path) -> list[Path]:
    """The kernel's file and all project files that it imports, directly or not."""
    found, ahead = set[Path](), [root / KERNEL]
    while ahead:
        file = ahead.pop()
        if file in found or not file.exists():
            continue
        found.add(file)
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                module = root.joinpath(*node.module.split("."))
                ahead += [module.with_suffix(".py"), *(module / f"{alias.name}.py" for alias in node.names)]
    return sorted(found)


def parameters_rule(root: Path) -> StructureRule:
    """No function of the kernel takes more than a handful: what belongs together is a record."""
    counted = [
        (count, f"{file.relative_to(root)}: {name} takes {count}")
        for file in kernel_files(root)
        for name, count in compiled_parameters(file)
    ]
    most = max((count for count, _ in counted), default=0)
    broken = tuple(text for count, text in counted if count > PARAMETERS_MAX)
    text = f"no function of the kernel with more than {PARAMETERS_MAX} parameters"
    return StructureRule(text, f"{len(counted)} functions, at most {most}", broken)


def lengths_rule(root: Path, lines_max: int) -> StructureRule:
    """No file longer than `lines_max`; data are not Python here."""
    lengths = {file.relative_to(root): len(file.read_text("utf-8").splitlines()) for file in sources(root)}
    broken = tuple(f"{file} has {lines} lines" for file, lines in lengths.items() if lines > lines_max)
    return StructureRule(
        f"no file over {lines_max} lines", f"{len(lengths)} files, at most {max(lengths.values())}", broken
    )


def unit_rule(root: Path, lines_max: int) -> StructureRule:
    """The unit only joins its machines."""
    lines = len((root / UNIT).read_text("utf-8").splitlines())
    broken = (f"{UNIT} has {lines} lines",) if lines >= lines_max else ()
    return StructureRule(f"{UNIT} under {lines_max} lines", f"{lines} lines", broken)


def imports_rule(root: Path) -> StructureRule:
    """Arrows go one way, as the contracts of pyproject.toml say."""
    linter = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run([str(linter)], cwd=root, capture_output=True, text=True, check=False)
    lines = [line.strip() for line in done.stdout.splitlines()]
    verdict = next((line for line in lines if line.startswith("Contracts:")), "no contract was judged")
    broken = tuple(line for line in lines if line.endswith("BROKEN"))
    if done.returncode != 0 and not broken:
        broken = (verdict,)
    return StructureRule("no import that runs back", verdict, broken)


def main(arguments: list[str] | None = None) -> int:
    """Print every rule; 1 where one is broken."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--root", type=Path, default=ROOT)
    parser.add_argument("--unit-lines", type=int, default=250)
    parser.add_argument("--file-lines", type=int, default=500)
    given = parser.parse_args(arguments)
    judged = (
        imports_rule(given.root),
        unit_rule(given.root, given.unit_lines),
        parameters_rule(given.root),
        lengths_rule(given.root, given.file_lines),
        *rules(given.root, ceilings()),
    )
    for rule in judged:
        sys.stdout.write(f"{'BROKEN' if rule.broken else 'holds '}  {rule.text}: {rule.found}\n")
        sys.stdout.writelines(f"          {text}\n" for text in rule.broken)
    return int(any(rule.broken for rule in judged))


if __name__ == "__main__":
    sys.exit(main())
