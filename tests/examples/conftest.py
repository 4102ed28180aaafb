"""A clone of the project in which examples are made as their recipes in docs/make-a.md say, and then checked."""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import indent
from typing import Any

from documents.structure import PACKAGES

ROOT = Path(__file__).resolve().parents[2]
COPIED = (*PACKAGES, "docs", "typings", "pyproject.toml", "Makefile", "README.md", "CHANGELOG.md")
CODE = [package for package in PACKAGES if package != "tests"]
# What a recipe says in a form that can be followed: a file that is laid in, and an entry of a table or class.
FILE = re.compile(r"\[`([\w./]+)`\]\(\.\./(tests/examples/[\w./]+)\)")
ENTRY = re.compile(r"```python\n# ([\w./]+), (in|before|at the end) ?(\w*)\n(.*?)```", re.DOTALL)
LABELS = re.compile(r"```po\n# ([\w./]+), at the end\n(.*?)```", re.DOTALL)
RECIPES = ("column", "command", "driving law", "fault", "paper", "sensor", "table of settings")
# Pages that follow from what an example adds, as `make docs` writes them.
PAGES = ("files", "faults", "sensors", "tables", "reproductions")
WRITE_PAGES = (
    f"import runpy\nfor page in {PAGES}: runpy.run_module(f'documents.{{page}}', run_name='__main__')"
)


def recipe(name: str) -> str:
    """One recipe of docs/make-a.md."""
    text = (ROOT / "docs/make-a.md").read_text("utf-8")
    return text.partition(f"## … {name}\n")[2].partition("\n## ")[0]


@dataclass
class Clone:
    """What a contributor has on disk; its code runs interpreted, as nothing in it has been compiled before."""

    root: Path
    touched: set[str] = field(default_factory=set)

    def add(self, file: Path, place: str) -> None:
        """Lay in a new file; it must not be there."""
        assert not (self.root / place).exists()
        shutil.copy(file, self.root / place)
        self.touched.add(place)

    def write(self, place: str, *pairs: tuple[str, str]) -> None:
        """Put text behind a text that is there once."""
        text = (self.root / place).read_text("utf-8")
        for behind, new in pairs:
            assert text.count(behind) == 1, (place, behind)
            text = text.replace(behind, behind + new)
        (self.root / place).write_text(text, "utf-8")
        self.touched.add(place)

    def entry(self, place: str, where: str, name: str, text: str) -> None:
        """Put text at the end of a table, class, file or returned call, or before a class; what it imports above."""
        new = ast.parse(text).body
        imports = [node for node in new if isinstance(node, ast.ImportFrom)]
        rows = text.split("\n", imports[-1].end_lineno or 0)[-1].strip("\n") if imports else text.strip("\n")
        lines = (self.root / place).read_text("utf-8").splitlines()
        body = ast.parse("\n".join(lines)).body
        if where == "at the end":
            lines += ["", "", rows]
        else:
            into = next(node for node in body if _named(node) == name)
            assert into.end_lineno is not None
            if where == "before":
                first = min([into.lineno, *(d.lineno for d in getattr(into, "decorator_list", ()))])
                lines.insert(first - 1, f"{rows}\n\n")
            elif isinstance(into, ast.ClassDef):
                lines.insert(into.end_lineno, indent(rows, "    "))
            else:
                lines.insert(into.end_lineno - 1, f"{rows},")
        top = next(
            node.lineno for node in body if isinstance(node, ast.ImportFrom) and node.module != "__future__"
        )
        lines.insert(top - 1, "\n".join(ast.unparse(node) for node in imports))
        (self.root / place).write_text("\n".join(lines) + "\n", "utf-8")
        self.touched.add(place)

    def follow(self, name: str) -> set[str]:
        """Do what a recipe says, to the word; the files touched."""
        text = recipe(name)
        before, self.touched = self.touched, set()
        for place, file in FILE.findall(text):
            self.add(ROOT / file, place)
        for place, where, name_there, entry in ENTRY.findall(text):
            self.entry(place, where, name_there, entry)
        for place, labels in LABELS.findall(text):
            with (self.root / place).open("a", encoding="utf-8") as catalogue:
                catalogue.write(f"\n{labels}")
        own, self.touched = self.touched, self.touched | before
        return own

    def finish(self) -> None:
        """What `make format` and `make docs` make of it."""
        self.tool("ruff", "format", *self.touched)
        self.tool("ruff", "check", "--fix", "--no-cache", *self.touched)
        self.succeeds("-c", WRITE_PAGES)

    def tool(self, name: str, *arguments: str) -> None:
        """Run a tool of `make check` there; it must have nothing to object to."""
        done = subprocess.run(
            [str(Path(sys.executable).with_name(name)), *arguments],
            cwd=self.root,
            env={**os.environ, "PYTHONPATH": str(self.root)},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr

    def succeeds(self, *arguments: str) -> str:
        """What Python prints there; it must end well."""
        done = self.python(*arguments)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def python(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run Python there."""
        environment = {**os.environ, "PYTHONPATH": str(self.root), "NUMBA_DISABLE_JIT": "1"}
        return subprocess.run(
            [sys.executable, *arguments],
            cwd=self.root,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )

    def run(self, scenario: Path | str) -> dict[str, Any]:
        """Figures of a run, with the directory that it left under `out`."""
        done = self.python("-m", "branchline.cli", "run", str(scenario), "--json", "--out", "out")
        assert done.stdout, done.stderr
        figures: dict[str, Any] = json.loads(done.stdout)
        return figures


def files_of(name: str) -> set[str]:
    """The files of the code that a recipe names."""
    code, text = rf"(?:{'|'.join(CODE)})/[\w./]+\.py", recipe(name)
    return {*re.findall(rf"`({code})`", text), *re.findall(rf"# ({code}), ", text)}


def _named(node: ast.stmt) -> str:
    """The name of a class or function, or of what is assigned."""
    if isinstance(node, ast.ClassDef | ast.FunctionDef):
        return node.name
    return node.target.id if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) else ""


def cloned(to: Path) -> Clone:
    """The project as it is, laid into a folder."""
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, to / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(ROOT / name, to / name)
    return Clone(to)
