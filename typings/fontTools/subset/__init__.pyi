"""What is used of fontTools.subset."""

from collections.abc import Iterable

from fontTools.ttLib import TTFont

class Options:
    notdef_outline: bool
    drop_tables: list[str]

class Subsetter:
    def __init__(self, options: Options | None = None) -> None: ...
    def populate(self, *, unicodes: Iterable[int] = ...) -> None: ...
    def subset(self, font: TTFont) -> None: ...
