"""What is used of fontTools.ttLib."""

from os import PathLike
from types import TracebackType
from typing import BinaryIO, Self

class TTFont:
    flavor: str | None
    def __init__(
        self,
        file: str | PathLike[str] | BinaryIO | None = None,
        *,
        recalcBBoxes: bool = True,
        recalcTimestamp: bool = True,
    ) -> None: ...
    def save(self, file: str | PathLike[str] | BinaryIO) -> None: ...
    def getBestCmap(self) -> dict[int, str]: ...
    def __enter__(self) -> Self: ...
    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None: ...
