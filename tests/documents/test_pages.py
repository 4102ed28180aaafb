"""README.md and the three pages that it leads to: their links lead somewhere, and what they show can be used."""

import re
import shlex
from pathlib import Path

import pytest
import typer
from typer.core import TyperGroup
from typer.testing import CliRunner

from branchline.cli import app, whole_command
from documents.site import anchor_of
from documents.structure import ROOT
from scenario.scenario import load_scenario

PLANNER = "docs/planner.md"
PAGES = ("README.md", PLANNER, "docs/signal-engineer.md", "docs/researcher.md")
NEW_LINE = "new line stations.csv asahi.toml --scenario asahi_day.toml"
TIMETABLE = "new timetable asahi_weekday.toml --line asahi.toml"  # in place of the published one


def blocks(page: str, language: str = "") -> list[str]:
    fenced = rf"^```{language}\n(.*?)^```$"
    return re.findall(fenced, (ROOT / page).read_text("utf-8"), re.MULTILINE | re.DOTALL)


def parse(line: str) -> None:
    command = whole_command()
    name, *arguments = shlex.split(line, comments=True)
    while isinstance(command, TyperGroup):
        name, *arguments = arguments
        command = command.commands[name]
    command.make_context(name, arguments).close()


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    for name, anchor in re.findall(r"\]\(([^)\s#]+)#?([^)\s]*)\)", (ROOT / page).read_text("utf-8")):
        target = (ROOT / page).parent / name
        assert target.exists(), name
        headings = re.findall(r"^#+ (.*)$", target.read_text("utf-8"), re.MULTILINE) if anchor else [""]
        assert anchor in {anchor_of(text) for text in headings}


@pytest.mark.parametrize("page", PAGES[1:])
def test_the_command_line_takes_what_is_shown(page: str) -> None:
    lines = re.findall(r"^branchline .*$", "".join(blocks(page)), re.MULTILINE)
    assert lines
    for line in lines:
        parse(line)


@pytest.mark.parametrize(
    "line", ["branchline walk day", "branchline run day --fast", "branchline new road a b"]
)
def test_what_it_does_not_take_is_noticed(line: str) -> None:
    with pytest.raises((KeyError, typer.TyperException)):
        parse(line)


def test_the_scenarios_of_the_planners_page_load(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("stations.csv").write_text(next(b for b in blocks(PLANNER) if b.startswith("name,")), "utf-8")
    assert all(CliRunner().invoke(app, shlex.split(line)).exit_code == 0 for line in (NEW_LINE, TIMETABLE))
    changed = dict[str, set[str]]()
    for text in blocks(PLANNER, "toml"):
        (name,) = re.findall(r'^id = "(.*)"$', text, re.MULTILINE)
        Path(f"{name}.toml").write_text(text, "utf-8")
        changed[name] = {change.file for change in load_scenario(f"{name}.toml").inputs.changes}
    assert changed["asahi_published"] == {"asahi_day.toml"}
    assert changed["slow_points"] == {"karasuyama.toml"}
    assert changed["heavy_morning"] >= {"karasuyama.toml", "karasuyama_weekday.toml", "ev_e301.toml"}
