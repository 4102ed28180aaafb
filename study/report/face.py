"""The Japanese characters of a page as a font inside it, so that no reader's machine shows boxes in their place."""

from __future__ import annotations

from base64 import b64encode
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Final

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

    A subset of IPAex Gothic, which its licence lets a document embed. The same characters give the same text.
    """
    wanted = {ord(character) for character in set(page) if ord(character) >= FIRST_JAPANESE}
    path = japanese_font()
    if not wanted or path is None:
        return ""
    from fontTools.subset import Options, Subsetter
    from fontTools.ttLib import TTFont

    options = Options()
    options.notdef_outline = True
    options.drop_tables += ["FFTM"]
    font = TTFont(path, recalcBBoxes=False, recalcTimestamp=False)  # outlines stay as packed
    subsetter = Subsetter(options)
    subsetter.populate(unicodes=sorted(wanted))
    subsetter.subset(font)
    font.flavor = "woff"
    buffer = BytesIO()
    font.save(buffer)
    data = b64encode(buffer.getvalue()).decode("ascii")
    return f'@font-face {{ font-family: "{FAMILY}"; src: url(data:font/woff;base64,{data}) format("woff"); }}'
