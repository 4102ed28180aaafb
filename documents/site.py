"""Hooks of mkdocs for `make site`: README.md and notebooks as pages, headings' anchors, and links that leave docs/.

A link to a file of the project that is no page becomes its path; one to nothing stays, and ends the strict build.
"""

from __future__ import annotations

import re
from pathlib import Path
from posixpath import join, normpath, relpath
from typing import Final

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from documents.notebooks import FOLDER as NOTEBOOKS
from documents.notebooks import notebook, page_of_notebook

ROOT: Final = Path(__file__).resolve().parent.parent
FIRST: Final = "index.md"
PAGES: Final = "docs"
_LINK: Final = re.compile(r"(?P<text>!?\[[^\]]*\])\((?P<path>[^)#:\s]+)(?P<anchor>#[^)\s]*)?\)")


def anchor_of(heading: str, separator: str = "-") -> str:
    """The anchor of a heading as forges and editors make it, so that one link serves in all of them."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", separator)


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Headings have the anchors that the pages' links name."""
    config.mdx_configs["toc"] = {**config.mdx_configs.get("toc", {}), "slugify": anchor_of}
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """README.md, which stands outside docs/, and the notebooks are made pages here."""
    files.append(File.generated(config, FIRST, content=(ROOT / "README.md").read_text("utf-8")))
    for file in sorted(NOTEBOOKS.glob("*.ipynb")):
        content = page_of_notebook(notebook(file.stem))
        files.append(File.generated(config, f"{NOTEBOOKS.name}/{file.stem}.md", content=content))
    return files


def on_page_markdown(markdown: str, page: Page, files: Files, **_: object) -> str:
    """Every link as one of the site."""
    here = "" if page.file.src_uri == FIRST else join(PAGES, page.file.src_uri)
    folder = here.rpartition("/")[0]

    def link_of_site(link: re.Match[str]) -> str:
        target = normpath(join(folder, link["path"]))
        place = join(PAGES, FIRST) if target == "README.md" else target.replace(".ipynb", ".md")
        if files.get_file_from_path(relpath(place, PAGES)) is not None:
            return f"{link['text']}({relpath(place, folder or PAGES)}{link['anchor'] or ''})"
        if not (ROOT / target).exists():
            return link[0]
        text = link["text"].strip("![]")
        return text if text.strip("`") == target else f"{text} (`{target}`)"

    return _LINK.sub(link_of_site, markdown)
