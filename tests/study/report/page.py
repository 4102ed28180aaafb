"""Reading a report as its modules do."""

from __future__ import annotations

import re
from typing import Any

from study.report.packing import inflated


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
