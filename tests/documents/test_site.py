"""`make site`: every page, nothing from elsewhere, and a broken link ends the build."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from documents.site import ROOT

FROM_ELSEWHERE = re.compile(r"<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)=[\"']?(?:https?:)?//[^>]*>")


def build(config: Path, site: Path) -> subprocess.CompletedProcess[str]:
    asked = (sys.executable, "-m", "mkdocs", "build", "--config-file", str(config), "--site-dir", str(site))
    quiet = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    return subprocess.run(asked, cwd=ROOT, env=quiet, capture_output=True, text=True, check=False)


def test_the_site_has_every_page_and_takes_nothing_from_elsewhere(tmp_path: Path) -> None:
    done = build(ROOT / "mkdocs.yml", tmp_path)
    assert done.returncode == 0, done.stderr
    pages = [path.relative_to(ROOT / "docs") for path in (ROOT / "docs").rglob("*.md")]
    assert len(pages) > 100
    for page in (Path("index.md"), *pages):
        text = (tmp_path / page.with_suffix(".html")).read_text("utf-8")
        assert FROM_ELSEWHERE.search(text) is None, page
    shown = (tmp_path / "notebooks/what-if.html").read_text("utf-8")
    assert "the largest difference is 53.9 s" in shown
    assert 'src="data:image/png;base64,' in shown
    assert 'href="notebooks/what-if.html"' in (tmp_path / "planner.html").read_text("utf-8")
    first = (tmp_path / "index.html").read_text("utf-8")
    assert 'href="planner.html"' in first
    assert 'src="images/train_graph.png"' in first
    assert FROM_ELSEWHERE.search('<script async src="https://example.org/a.js"></script>')


@pytest.mark.nightly
def test_a_link_to_nothing_ends_the_build(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "docs", tmp_path / "docs")
    with (tmp_path / "docs/planner.md").open("a", encoding="utf-8") as page:
        page.write("\n[gone](nowhere.md), [no heading](files.md#nowhere)\n")
    config = tmp_path / "mkdocs.yml"
    config.write_text(f"INHERIT: {ROOT}/mkdocs.yml\nhooks: [{ROOT}/documents/site.py]\n", "utf-8")
    done = build(config, tmp_path / "site")
    assert done.returncode == 1
    assert "'planner.md' contains a link 'nowhere.md'" in done.stderr
    assert "does not contain an anchor '#nowhere'" in done.stderr
