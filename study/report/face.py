"""The Japanese characters of a page as a font inside it, so that no reader's machine shows boxes in their place."""

from __future__ import annotations

from base64 import b64encode
from importlib.metadata import version
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Final

from network.code_store import CodeStore, kept_folder

FAMILY: Final = "branchline-ja"  # named last in the page's list of fonts, before what the machine has
FACE: Final = "/* Japanese characters of this page */"  # where the template has it
FIRST_JAPANESE: Final = 0x2E80  # radicals; what comes before is in every font


def japanese_font() -> Path | None:
    """The file of the IPA font; None where its package is not installed."""
    spec = find_spec("matplotlib_fontja")
    if spec is None or not spec.submodule_search_locations:
        return None
    path = Path(spec.submodule_search_locations[0]) / "fonts" / "ipaexg.ttf"
    return path if path.is_file() else None


def japanese_face(page: str) -> str:
    """An @font-face of the characters of `page` from 0x2E80 on; empty where it has none, or no font has them.

    A subset of IPAex Gothic, which its licence lets a document embed. The same characters give the same text; it is
    kept for the next page that has them, as most pages of a line do.
    """
    wanted = sorted({ord(character) for character in set(page) if ord(character) >= FIRST_JAPANESE})
    path = japanese_font()
    if not wanted or path is None:
        return ""
    made_by = (Path(__file__).read_bytes(), version("fonttools"), version("matplotlib-fontja"))
    fonts = CodeStore(kept_folder() / "fonts")
    kept = fonts.made(FAMILY, (wanted, made_by), lambda: _subset(path, wanted))
    data = b64encode(kept).decode("ascii")
    return f'@font-face {{ font-family: "{FAMILY}"; src: url(data:font/woff;base64,{data}) format("woff"); }}'


def _subset(path: Path, wanted: list[int]) -> bytes:
    """The font of these characters, as woff."""
    from fontTools.subset import Options, Subsetter
    from fontTools.ttLib import TTFont

    options = Options()
    options.notdef_outline = True
    options.drop_tables += ["FFTM"]
    font = TTFont(path, recalcBBoxes=False, recalcTimestamp=False)  # outlines stay as packed
    subsetter = Subsetter(options)
    subsetter.populate(unicodes=wanted)
    subsetter.subset(font)
    font.flavor = "woff"
    buffer = BytesIO()
    font.save(buffer)
    return buffer.getvalue()
