"""The report of a drill, compared with another one, opened in Japanese: nothing on it is left in English."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
import pytest

from study.compare.comparison import compare
from study.compare.parts import parts_against
from study.compare.side import of_run
from study.drilling.drill import Drill, drill_shown, run_drill
from study.record.shown import shown_of
from study.report.report import write_report
from study.report.style import drawing
from study.runner.run import PartyLink
from tests.browser.test_report_in_chromium import PAPERS as EVERY_PAPER
from tests.browser.test_report_in_chromium import opened, picture
from tests.study.wording.test_wording import english_in

if TYPE_CHECKING:
    from playwright.sync_api import Browser

PAPERS = (*EVERY_PAPER, "compared")
TEXTS = """
() => {
  const texts = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const at = node.parentElement;
    const shown = !at.closest("script, style, datalist, noscript") && at.checkVisibility();
    if (shown) texts.push(node.textContent.trim());
  }
  return texts.filter((text) => text);
}
"""
# A name or a code in any language: files and keys of inputs, ids, digests, the other language.
NAMES = re.compile(
    r"""^["{\[].*$|^(act|expect|timetable)$|CSV|English|Ctrl|Shift|Enter|EV-E301|[0-9a-f]{16,}"""
    r"""|[\w.\[\]"-]*[._\[][\w.\[\]"-]*"""
)


@pytest.fixture(scope="module")
def drills() -> tuple[Drill, Drill]:
    """Two drills of one line with faults, acts, refusals and interventions."""
    found = [
        run_drill(f"rtri/{name}", PartyLink.SIMULATED)
        for name in ("06_unit_manager_link", "09b_manager_power_by_hand")
    ]
    return found[0], found[1]


@pytest.fixture(scope="module")
def report(drills: tuple[Drill, Drill], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The second drill's report, with what changed against the first."""
    base, new = drills
    setup = new.run.scenario.setup
    with drawing(), mpl.rc_context():
        parts = parts_against(compare([of_run(base.run, "A"), of_run(new.run, "B")], 1.0), graphs=False)
    drill = drill_shown(new)
    kept = shown_of(new.run.result, new.run.failures, (), drill, {})
    facts = kept.facts(new.run.summary, new.run.scenario.inputs)
    folder = tmp_path_factory.mktemp("japanese")
    return write_report(folder, setup.line, setup.timetable, new.run.tables, facts, {}, drill, parts)


def left_in_english(texts: list[str], names: set[str]) -> Iterator[str]:
    for text in texts:
        bare = NAMES.sub(" ", text)
        if any(word not in names for word in english_in(bare)):
            yield text


def test_a_japanese_planner_reads_no_english(
    browser: Browser, report: Path, drills: tuple[Drill, Drill]
) -> None:
    scenario = drills[1].run.scenario
    titles = {
        word
        for text in (scenario.name, scenario.setup.timetable.head.name)
        for word in re.findall(r"\w+", text)
    }
    with opened(browser, report) as page:
        page.click("#language")
        left: dict[str, list[str]] = {}
        for paper in PAPERS:
            page.click(f"#tab-{paper}")
            page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
            page.wait_for_timeout(50)
            picture(page, f"japanese-{paper}")
            left[paper] = sorted(set(left_in_english(page.evaluate(TEXTS), titles)))
        assert {paper: texts for paper, texts in left.items() if texts} == {}


def test_the_legend_says_what_a_faults_bands_are(browser: Browser, report: Path) -> None:
    with opened(browser, report) as page:
        assert "while a fault lasts (F)" in page.locator(".legend").inner_text()
        picture(page, "drill-en-graph")
        page.click("#language")
        assert "故障の時間（F）" in page.locator(".legend").inner_text()
