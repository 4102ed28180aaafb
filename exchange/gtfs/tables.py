"""The tables of a GTFS feed, from a zip archive or a folder: rows of the columns asked for, and no more than fits.

A feed comes from anywhere: what an archive says of its sizes is not believed, every table is cut off at a cap, and text
is UTF-8. The standard library's `csv` and `zipfile` do; libraries for GTFS bring pandas with them (decision 019).
"""

from __future__ import annotations

import csv
import io
import zipfile
import zlib
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Final

from network.errors import InputError

# of one table, unpacked: a national feed has more, a railway's line far less
TABLE_BYTES_MAX: Final = 256 << 20
ARCHIVE_FILES_MAX: Final = 1000
_CHUNK: Final = 1 << 16
csv.field_size_limit(TABLE_BYTES_MAX)  # a feed of ours carries a timetable's head in one field
_DAMAGED: Final = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    NotImplementedError,
    RuntimeError,
    OSError,
    ValueError,
)


@dataclass(frozen=True, slots=True)
class GtfsRow:
    """A row of a table: its line in the file, and the texts of the columns asked for, empty where there are none."""

    line: int
    texts: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Feed:
    """A feed: the zip archive or folder, and the names of the tables in it."""

    path: Path
    names: frozenset[str]

    @staticmethod
    def at_path(path: Path) -> Feed:
        """Look at a feed. Raises InputError for what is neither an archive nor a folder with tables."""
        file = str(path)
        try:
            if path.is_dir():
                names = frozenset(item.name for item in path.iterdir() if item.is_file())
            else:
                if not path.is_file():
                    raise InputError(
                        file, "", None, "a GTFS feed: a zip archive, or a folder with its tables"
                    )
                with zipfile.ZipFile(path) as archive:
                    names = frozenset(archive.namelist()[: ARCHIVE_FILES_MAX + 1])
        except _DAMAGED as error:
            raise InputError(
                file, "", None, f"a GTFS feed, which is a zip archive ({_why(error)})"
            ) from error
        if len(names) > ARCHIVE_FILES_MAX:
            raise InputError(file, "", None, f"an archive of at most {ARCHIVE_FILES_MAX} files")
        inside = [name for name in names if name.endswith("/stop_times.txt")]
        if "stop_times.txt" not in names and inside:
            raise InputError(
                file, "stop_times.txt", None, f"tables at the top of the archive, not {inside[0]}"
            )
        return Feed(path, names)

    def has_table(self, table: str) -> bool:
        """Whether a table is in it."""
        return table in self.names

    def rows(self, table: str, needed: Sequence[str], more: Sequence[str] = ()) -> Iterator[GtfsRow]:
        """Rows of a table: texts of the columns `needed`, then of those that there may be. Raises InputError."""
        file = f"{self.path}: {table}"
        if table not in self.names:
            raise InputError(str(self.path), table, None, "this table, which every feed has")
        with self._text(table) as text:
            lines = csv.reader(text, strict=True)
            try:
                header = [name.strip() for name in next(lines, list[str]())]
                missing = [name for name in needed if name not in header]
                if missing:
                    found = ", ".join(header[:12]) or "none"
                    raise InputError(file, missing[0], None, f"this column; the columns are: {found}")
                places = [header.index(name) if name in header else None for name in (*needed, *more)]
                for cells in lines:
                    if not any(cells):
                        continue
                    yield GtfsRow(
                        lines.line_num,
                        tuple(
                            cells[place].strip() if place is not None and place < len(cells) else ""
                            for place in places
                        ),
                    )
            except csv.Error as error:
                raise InputError(file, f"line {lines.line_num}", None, f"a table of CSV ({error})") from error
            except UnicodeDecodeError as error:
                where = f"after line {lines.line_num}: byte 0x{error.object[error.start]:02x}"
                raise InputError(file, "", None, f"text in UTF-8 ({where})") from error
            except _DAMAGED as error:
                raise InputError(file, "", None, f"a whole table ({_why(error)})") from error

    def columns(self, table: str) -> frozenset[str]:
        """Names of a table's columns; none where there is no table."""
        if table not in self.names:
            return frozenset()
        with self._text(table) as text:
            try:
                return frozenset(name.strip() for name in next(csv.reader(text), list[str]()))
            except (csv.Error, *_DAMAGED):
                return frozenset()

    @contextmanager
    def _text(self, table: str) -> Generator[IO[str]]:
        file = f"{self.path}: {table}"
        try:
            if self.path.is_dir():
                with (self.path / table).open("rb") as stream:
                    yield _as_text(stream, file)
                return
            with zipfile.ZipFile(self.path) as archive, archive.open(table) as stream:
                yield _as_text(stream, file)
        except InputError:
            raise
        except _DAMAGED as error:
            raise InputError(file, "", None, f"a whole table ({_why(error)})") from error


class _Capped(io.RawIOBase):
    """A stream that gives no more than a table may have: an archive can unpack to a million times its size."""

    def __init__(self, stream: IO[bytes], file: str) -> None:
        super().__init__()
        self._stream = stream
        self._file = file
        self._left = TABLE_BYTES_MAX

    def readable(self) -> bool:
        """It is for reading."""
        return True

    def readinto(self, buffer: memoryview) -> int:  # type: ignore[override]
        """The next bytes; InputError beyond the cap."""
        data = self._stream.read(min(len(buffer), _CHUNK))
        self._left -= len(data)
        if self._left < 0:
            raise InputError(self._file, "", None, f"a table of at most {TABLE_BYTES_MAX >> 20} MiB")
        buffer[: len(data)] = data
        return len(data)


def _as_text(stream: IO[bytes], file: str) -> IO[str]:
    return io.TextIOWrapper(
        io.BufferedReader(_Capped(stream, file), _CHUNK), encoding="utf-8-sig", newline=""
    )


def _why(error: BaseException) -> str:
    text = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return text or type(error).__name__
