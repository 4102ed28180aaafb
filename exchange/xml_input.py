"""XML that somebody else wrote, read into a tree: no entities, no outer files, no depth or size without end.

A file that declares a document type is refused whole: none of the formats read here needs one, and it is what
entities that grow without end, or that reach for other files, are declared in.
"""

from __future__ import annotations

import codecs
import xml.etree.ElementTree as ET
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Final
from xml.parsers import expat

from network.errors import InputError
from network.files.text_input import opened

XML_BYTES_MAX: Final = 64 << 20  # a whole province of rails from OpenStreetMap; read in about ten seconds
DEPTH_MAX: Final = 64  # the deepest element of railML 3.2 is eleven levels down
ELEMENTS_MAX: Final = 2_000_000
_GZIP_MARK: Final = b"\x1f\x8b"
_BLOCK_BYTES: Final = 1 << 16
_GZIP_WINDOW: Final = 31  # of zlib: the form of gzip, the widest window


def read_xml(path: Path) -> ET.Element:
    """The root of an XML file, plain or gzipped; names are `{namespace}name`. Raises InputError."""
    file = str(path)
    builder = ET.TreeBuilder()
    parser = expat.ParserCreate(namespace_separator="}")
    parser.buffer_text = True
    guard = _Guard(file, builder, parser)
    parser.StartElementHandler = guard.start
    parser.EndElementHandler = guard.end
    parser.CharacterDataHandler = guard.text
    parser.StartDoctypeDeclHandler = guard.refuse
    try:
        for block in _blocks(path):
            parser.Parse(block, False)
        parser.Parse(b"", True)
    except expat.ExpatError as error:
        why = expat.ErrorString(error.code)
        raise InputError(file, f"line {error.lineno}", None, f"whole and valid XML ({why})") from error
    except (LookupError, ValueError) as error:  # an encoding that Python does not know, or no single-byte one
        raise InputError(file, "", None, f"XML in UTF-8 or another known encoding ({error})") from error
    return builder.close()


class _Guard:
    """What the parser tells, handed on to the builder within the limits."""

    def __init__(self, file: str, builder: ET.TreeBuilder, parser: expat.XMLParserType) -> None:
        self._file = file
        self._builder = builder
        self._parser = parser
        self._depth = 0
        self._count = 0

    def start(self, name: str, attributes: dict[str, str]) -> None:
        """An element begins."""
        self._depth += 1
        self._count += 1
        if self._depth > DEPTH_MAX:
            raise self._error(f"XML with at most {DEPTH_MAX} elements in one another")
        if self._count > ELEMENTS_MAX:
            raise self._error(f"XML with at most {ELEMENTS_MAX} elements")
        self._builder.start(_braced(name), {_braced(key): value for key, value in attributes.items()})

    def end(self, name: str) -> None:
        """An element ends."""
        self._depth -= 1
        self._builder.end(_braced(name))

    def text(self, data: str) -> None:
        """Text between elements."""
        self._builder.data(data)

    def refuse(self, *_declared: object) -> None:
        """A document type is declared."""
        raise self._error("XML without a document type (<!DOCTYPE ...>), in which entities may be hidden")

    def _error(self, expected: str) -> InputError:
        return InputError(self._file, f"line {self._parser.CurrentLineNumber}", None, expected)


def local_name(element: ET.Element) -> str:
    """The name of an element without its namespace."""
    return element.tag.rpartition("}")[2]


def namespace_of(element: ET.Element) -> str:
    """The namespace of an element; empty if it has none."""
    return element.tag[1:].partition("}")[0] if element.tag.startswith("{") else ""


def number(file: str, element: ET.Element, name: str) -> float | None:
    """A finite number in an attribute; None where it is not given. Raises InputError for anything else."""
    text = element.get(name)
    if text is None or not text.strip():
        return None
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not abs(value) < float("inf"):
        raise InputError(file, f"{_where(element)}: {name}", text, "a number")
    return value


def needed_number(file: str, element: ET.Element, name: str) -> float:
    """A finite number that must be there. Raises InputError."""
    value = number(file, element, name)
    if value is None:
        raise InputError(file, f"{_where(element)}: {name}", None, "this attribute, which is missing")
    return value


def needed_attribute(file: str, element: ET.Element, name: str) -> str:
    """An attribute that must be there. Raises InputError."""
    text = element.get(name)
    if not text:
        raise InputError(file, f"{_where(element)}: {name}", None, "this attribute, which is missing")
    return text


def _where(element: ET.Element) -> str:
    named = element.get("id")
    return f"{local_name(element)} {named}" if named else local_name(element)


def _braced(name: str) -> str:
    return "{" + name if "}" in name else name


def _blocks(path: Path) -> Iterator[bytes]:
    """The bytes of a file, unpacked if it is gzipped, at most XML_BYTES_MAX. Raises InputError."""
    file = str(path)
    try:
        with opened(path) as stream:
            first = stream.read(_BLOCK_BYTES)
            if not first.removeprefix(codecs.BOM_UTF8).strip():
                raise InputError(file, "", None, "XML, but the file is empty")
            unpack = zlib.decompressobj(_GZIP_WINDOW) if first.startswith(_GZIP_MARK) else None
            size, block = 0, first
            while block:
                for part in [block] if unpack is None else _unpacked(unpack, block):
                    size += len(part)
                    if size > XML_BYTES_MAX:
                        raise InputError(file, "", None, f"XML of at most {XML_BYTES_MAX >> 20} MiB")
                    yield part
                block = stream.read(_BLOCK_BYTES)
            if unpack is not None and not unpack.eof:
                raise InputError(file, "", None, "a whole gzip file, but it is cut off")
    except zlib.error as error:
        raise InputError(file, "", None, f"a valid gzip file ({error})") from error


def _unpacked(unpack: zlib._Decompress, block: bytes) -> Iterator[bytes]:
    """What a block of a gzip file holds, a part at a time: little may hold very much."""
    while block and not unpack.eof:
        yield unpack.decompress(block, _BLOCK_BYTES)
        block = unpack.unconsumed_tail
