"""The text of an OuDia file as a tree, faithfully: what is read and written again is the same, unknown keys and all.

A file is lines `Key=value` and nodes: a line `Name.` begins one, a line `.` ends it. Keys may come again, and their
order counts. In a value `\\n` is the end of a line and `\\\\` a backslash. OuDia (`FileType=OuDia.1.xx`) writes cp932,
OuDiaSecond (`FileType=OuDiaSecond.1.xx`) UTF-8 with its mark, which is what tells them apart, and ends of line CR LF.
Source: "ファイル形式変更点" on OuDiaSecond's site; docs/analysis/03 of route-builders/oudia-web, made from ver. 2.06.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from network.errors import InputError
from network.files.text_input import japanese_encoding, read_bytes, wide_encoding

BYTES_MAX: Final = 16 << 20  # fifty times a file of two thousand trains
NESTING_MAX: Final = 8  # the deepest node of the format is five levels down
_TYPE: Final = re.compile(r"(OuDia|OuDiaSecond)\.1\.(\d{1,4})")
_FIRST: Final = b"FileType="
_HELP: Final = "an OuDia file, whose first line is FileType=OuDia.1.xx or FileType=OuDiaSecond.1.xx"
_CP932: Final = "cp932"
_DOUBLED: Final = re.compile(r"([^\x00-\x7f])\\")
_ESCAPED: Final = re.compile(r"\\([n\\])")


@dataclass(frozen=True, slots=True)
class OudiaEntry:
    """A line `key=value`; `text` is what stands behind the `=` in the file, None on a line without one."""

    key: str
    text: str | None
    value: str = ""  # what the text means, its escapes resolved


@dataclass(frozen=True, slots=True)
class OudiaNode:
    """A node: its name, and its lines and nodes in order; `line` is where it begins in the file, from 1."""

    name: str
    items: tuple[OudiaEntry | OudiaNode, ...]
    line: int = field(default=0, compare=False)

    def text(self, key: str, default: str = "") -> str:
        """Value of the first line of that key."""
        return next((item.value for item in self.entries(key)), default)

    def entries(self, key: str) -> Iterator[OudiaEntry]:
        """Lines of that key."""
        return (item for item in self.items if isinstance(item, OudiaEntry) and item.key == key)

    def nodes(self, name: str) -> tuple[OudiaNode, ...]:
        """Nodes of that name."""
        return tuple(item for item in self.items if isinstance(item, OudiaNode) and item.name == name)

    def node(self, name: str) -> OudiaNode | None:
        """The first node of that name."""
        return next(iter(self.nodes(name)), None)


@dataclass(frozen=True, slots=True)
class OudiaText:
    """A whole file: its tree under a root without a name, and how it is spelt in bytes."""

    root: OudiaNode
    utf8: bool  # else cp932
    newline: str = "\r\n"
    ended: bool = True  # with an end of line behind the last one

    @property
    def second(self) -> bool:
        """Whether it is a file of OuDiaSecond."""
        return self.root.text("FileType").startswith("OuDiaSecond.")

    @property
    def minor(self) -> int:
        """The last number of the FileType."""
        return int(self.root.text("FileType").rpartition(".")[2])

    def encoded(self) -> bytes:
        """The file. Raises UnicodeEncodeError for what cp932 has not."""
        text = self.newline.join(_lines(self.root.items)) + (self.newline if self.ended else "")
        return codecs.BOM_UTF8 + text.encode("utf-8") if self.utf8 else text.encode(_CP932)


def entry(key: str, value: object) -> OudiaEntry:
    """A line of a value without escapes."""
    text = str(value).replace("\r\n", "\n").replace("\r", "\n")
    return OudiaEntry(key, text.replace("\\", "\\\\").replace("\n", "\\n"), text)


def unescaped(text: str, *, cp932: bool = False) -> str:
    """A value as it is meant; a backslash before anything else stands for itself.

    `cp932`: OuDia doubles each byte of a backslash, so a character that ends in such a byte has one behind it.
    """
    if cp932:
        text = _DOUBLED.sub(lambda match: match[1] if _ends_as_backslash(match[1]) else match[0], text)
    return _ESCAPED.sub(lambda match: "\n" if match[1] == "n" else "\\", text)


def read_oudia(path: Path) -> OudiaText:
    """Read a file. Raises InputError for a foreign file, another encoding, and one that breaks off."""
    return parse_oudia(read_bytes(path, BYTES_MAX), str(path))


def parse_oudia(data: bytes, file: str) -> OudiaText:
    """Parse what a file holds; `file` names it in errors. Raises InputError."""
    wide = wide_encoding(data)
    if wide:
        raise InputError(file, "", None, f"text in cp932 (OuDia) or UTF-8 (OuDiaSecond), not in {wide}")
    utf8 = data.startswith(codecs.BOM_UTF8)
    if not data.removeprefix(codecs.BOM_UTF8).lstrip().startswith(_FIRST):
        raise InputError(file, "", None, _HELP)
    if b"\0" in data:
        line = data.count(b"\n", 0, data.index(b"\0")) + 1
        raise InputError(file, "", None, f"text, without the zero byte in line {line}")
    text = _decoded(file, data, utf8=utf8)
    newline = "\r\n" if "\r\n" in text else "\n"
    root = _tree(file, text.replace("\r\n", "\n"), cp932=not utf8)
    kind = root.text("FileType")
    if not _TYPE.fullmatch(kind):
        raise InputError(file, "FileType", kind, "OuDia.1.xx or OuDiaSecond.1.xx")
    if kind.startswith("OuDiaSecond.") and not utf8 and not data.isascii():
        expected = (
            "OuDiaSecond's text in UTF-8 with its mark at the front (BOM), but it is in Shift-JIS (cp932)"
        )
        raise InputError(file, "", None, expected)
    return OudiaText(root, utf8, newline, text.endswith("\n"))


def _decoded(file: str, data: bytes, *, utf8: bool) -> str:
    """The text of a file; one in another encoding is named as that."""
    if not utf8 and not data.isascii():
        if _is_utf8(data):
            expected = "text in UTF-8 with its mark at the front (BOM), or in Shift-JIS (cp932); it is in UTF-8 without"
            raise InputError(file, "", None, expected)
        found = japanese_encoding(data)
        if found is not None and found[0] != "Shift-JIS":
            expected = f"text in Shift-JIS, but it is in {found[0]}; convert it: iconv -f {found[1]} -t CP932 OLD > NEW"
            raise InputError(file, "", None, expected)
    codec, name = ("utf-8", "UTF-8") if utf8 else (_CP932, "Shift-JIS (cp932)")
    data = data.removeprefix(codecs.BOM_UTF8)
    try:
        return data.decode(codec)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        if error.start >= len(data) - 4:  # longer is no character
            raise InputError(file, "", None, _whole(line, "in the middle of a character")) from error
        expected = f"text in {name} (byte 0x{data[error.start]:02x} in line {line} is none)"
        raise InputError(file, "", None, expected) from error


def _is_utf8(data: bytes) -> bool:
    """Whether bytes are UTF-8, a last character that breaks off left aside."""
    try:
        codecs.getincrementaldecoder("utf-8")().decode(data, final=False)
    except UnicodeDecodeError:
        return False
    return True


def _whole(line: int, what: str) -> str:
    return f"a whole file: it breaks off {what} (line {line})"


def _tree(file: str, text: str, *, cp932: bool) -> OudiaNode:
    """The tree of a text; nodes that are still open at its end show that it was cut off."""
    open_nodes: list[tuple[str, int, list[OudiaEntry | OudiaNode]]] = [("", 0, [])]
    lines = text.split("\n")
    if lines[-1] == "":
        lines.pop()
    for number, line in enumerate(lines, start=1):
        items = open_nodes[-1][2]
        if line == ".":
            if len(open_nodes) == 1:
                raise InputError(file, f"line {number}", line, "no end of a node here: none is open")
            name, begun, own = open_nodes.pop()
            open_nodes[-1][2].append(OudiaNode(name, tuple(own), begun))
        elif line.endswith(".") and "=" not in line:
            if len(open_nodes) > NESTING_MAX:
                raise InputError(
                    file, f"line {number}", line, f"nodes at most {NESTING_MAX} deep in one another"
                )
            open_nodes.append((line[:-1], number, []))
        else:
            key, equals, value = line.partition("=")
            items.append(OudiaEntry(key, value if equals else None, unescaped(value, cp932=cp932)))
    if len(open_nodes) > 1:
        name, begun, _ = open_nodes[-1]
        expected = _whole(len(lines), f"in {name}, which begins in line {begun}")
        raise InputError(file, "", None, expected)
    return OudiaNode("", tuple(open_nodes[0][2]))


def _ends_as_backslash(character: str) -> bool:
    return character.encode(_CP932, errors="replace").endswith(b"\\")


def _lines(items: Iterable[OudiaEntry | OudiaNode]) -> Iterator[str]:
    for item in items:
        if isinstance(item, OudiaNode):
            yield f"{item.name}."
            yield from _lines(item.items)
            yield "."
        else:
            yield item.key if item.text is None else f"{item.key}={item.text}"
