"""One file of the modules under `web`: a page that is opened from disk cannot import from the files beside it.

Each module becomes a data: URL in an import map, and its relative imports the names of that map. The modules themselves
stay as they are, so that a page that is served can import them from their folder.
"""

from __future__ import annotations

import json
import re
from base64 import b64encode
from functools import cache
from importlib.resources import files
from typing import Final

from study.wording.catalogue import phrases_of

PREFIX: Final = "branchline/"
PAGE_CONTEXTS: Final = ("", "call", "short")
_IMPORT: Final = re.compile(r"""(\bfrom\s+|\bimport\s+)(["'])\./([\w-]+\.js)\2""")


@cache
def modules() -> dict[str, str]:
    """Name and text of every module of the page."""
    folder = files("study") / "report" / "web"
    found = {item.name: item.read_text("utf-8") for item in folder.iterdir() if item.name.endswith(".js")}
    return dict(sorted(found.items()))


def style_sheet() -> str:
    """The page's style sheet."""
    return (files("study") / "report" / "web" / "report.css").read_text("utf-8")


@cache
def words_of_the_page() -> dict[str, str]:
    """The catalogue's Japanese for what the modules say, by English, with the context as gettext joins them."""
    quoted = set("".join(modules().values()).replace(r"\"", "'").split('"'))
    return {
        f"{context}\u0004{english}" if context else english: said.ja
        for context in PAGE_CONTEXTS
        for english, said in phrases_of(context).items()
        if json.dumps(english, ensure_ascii=False)[1:-1].replace(r"\"", "'") in quoted
    }


def import_map() -> str:
    """The import map, as text that can stand in a script element."""
    urls = {
        PREFIX + name: "data:text/javascript;charset=utf-8;base64,"
        + b64encode(_IMPORT.sub(rf"\1\2{PREFIX}\3\2", text).encode("utf-8")).decode("ascii")
        for name, text in modules().items()
    }
    return json.dumps({"imports": urls}, separators=(",", ":"))
