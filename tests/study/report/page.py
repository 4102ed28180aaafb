"""Reading a report as its modules do."""

import re
import zlib
from base64 import b64decode
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import msgspec
import polars as pl

from study.report.data import ReportedRun

VOID_TAGS = {"meta", "br", "link", "img", "input", "hr"}


class Page(HTMLParser):
    """Tags of a page: whether they close in order, their ids and what they refer to."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.references: list[str] = []
        self.fetched: list[str] = []
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID_TAGS:
            self.open.append(tag)
        for name, value in attrs:
            if name == "id" and value:
                self.ids.append(value)
            if name in ("href", "xlink:href", "src", "srcset", "data"):
                self.fetched.append(value or "")
            self.references += re.findall(r"url\(([^)]*)\)", value or "")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID_TAGS:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def with_table(run: ReportedRun, **frames: pl.DataFrame) -> ReportedRun:
    return replace(run, tables=replace(run.tables, **frames))


def inflated(text: str) -> dict[str, Any]:
    """What `deflated` was given."""
    return msgspec.json.decode(zlib.decompress(b64decode(text, validate=True)), type=dict[str, Any])


def payload_of(page: str) -> dict[str, Any]:
    """What the page's modules are given."""
    found: dict[str, Any] = {}
    for name in ("payload", "payload-courses"):
        packed = re.search(rf'<script type="application/octet-stream" id="{name}">([^<]*)</script>', page)
        assert packed is not None
        found |= inflated(packed[1])
    return found


def table_in(payload: dict[str, Any], name: str) -> dict[str, list[Any]]:
    """Columns of a table by their headings."""
    (table,) = (table for table in payload["tables"] if table["id"] == name)
    return {column["label"]: column["values"] for column in table["columns"]}
