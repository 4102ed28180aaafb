"""README.md and the three pages that it leads to: their links lead somewhere, and what they show can be used."""

from __future__ import annotations

import ast
import re
import shlex
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
import typer
from typer.core import TyperGroup
from typer.main import get_command
from typer.testing import CliRunner

from branchline.cli import app
from documents.structure import ROOT
from scenario.scenario import load_scenario

PAGES = ("README.md", "docs/planner.md", "docs/signal-engineer.md", "docs/researcher.md")
README_LINES = 120


def text_of(page: str) -> str:
    return (ROOT / page).read_text("utf-8")


def blocks(page: str, language: str = "") -> list[str]:
    """The fenced blocks of one language, in order."""
    return re.findall(rf"^```{language}\n(.*?)^```$", text_of(page), re.MULTILINE | re.DOTALL)


def commands(page: str) -> Iterator[str]:
    for block in blocks(page):
        yield from (line for line in block.splitlines() if line.startswith("branchline "))


def parse(line: str) -> None:
    """Raises `KeyError` for a command that there is not, `typer.TyperException` for such an option or argument."""
    command = get_command(app)
    _, *arguments = shlex.split(line, comments=True)
    name = ""
    while isinstance(command, TyperGroup):
        name = arguments.pop(0)
        command = command.commands[name]
    with command.make_context(name, arguments):
        pass


def anchors(page: Path) -> set[str]:
    """The names that GitHub gives to a page's headings."""
    headings = re.findall(r"^#+ (.*)$", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    links = re.findall(r"\]\(([^)\s]+)\)", text_of(page))
    assert links
    for link in links:
        name, _, anchor = link.partition("#")
        target = (ROOT / page).parent / name
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


@pytest.mark.parametrize("line", sorted({line for page in PAGES for line in commands(page)}))
def test_the_command_line_takes_what_is_shown(line: str) -> None:
    parse(line)


@pytest.mark.parametrize(
    "line", ["branchline walk day", "branchline run day --fast", "branchline new road a b"]
)
def test_what_it_does_not_take_is_noticed(line: str) -> None:
    with pytest.raises((KeyError, typer.TyperException)):
        parse(line)


def test_the_scenarios_of_the_planners_page_load(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = "docs/planner.md"
    monkeypatch.chdir(tmp_path)
    (stations,) = (block for block in blocks(page) if block.startswith("name,"))
    Path("stations.csv").write_text(stations, "utf-8")
    for line in (
        "new line stations.csv asahi.toml --scenario asahi_day.toml",
        "new timetable asahi_weekday.toml --line asahi.toml",  # in place of the published one
    ):
        done = CliRunner().invoke(app, shlex.split(line), catch_exceptions=False)
        assert done.exit_code == 0, done.output
    changed = dict[str, set[str]]()
    for text in blocks(page, "toml"):
        (name,) = re.findall(r'^id = "(.*)"$', text, re.MULTILINE)
        Path(f"{name}.toml").write_text(text, "utf-8")
        changed[name] = {change.file for change in load_scenario(f"{name}.toml").inputs.changes}
    assert changed["asahi_published"] == {"asahi_day.toml"}
    assert changed["slow_points"] == {"karasuyama.toml"}
    assert changed["heavy_morning"] >= {"karasuyama.toml", "karasuyama_weekday.toml", "ev_e301.toml"}


def test_what_python_imports_is_there() -> None:
    found = [node for block in blocks("docs/researcher.md", "python") for node in ast.parse(block).body]
    imports = [node for node in found if isinstance(node, ast.ImportFrom)]
    assert imports
    for node in imports:
        assert node.module is not None
        assert all(hasattr(import_module(node.module), name.name) for name in node.names)


def test_the_readme_is_short() -> None:
    assert len(text_of("README.md").splitlines()) <= README_LINES
