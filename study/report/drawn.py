"""A picture as a figure, as bytes of PNG or SVG, or as a notebook shows it; the same picture gives the same bytes."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
from matplotlib.figure import Figure

from network.errors import InputError
from study.report.style import drawing

DPI: Final = 150


class Format(Enum):
    """How a plot is written; the ending of its file."""

    PNG = "png"
    SVG = "svg"
    CSV = "csv"


_SAVED: Final[dict[Format, dict[str, Any]]] = {
    Format.PNG: {"dpi": DPI, "metadata": {"Software": None}},
    Format.SVG: {"metadata": {"Date": None, "Creator": None}},
}


@dataclass(frozen=True, slots=True)
class DrawnFigure:
    """A matplotlib figure in the look of the reports; `name` sets the ids in its SVG apart from those of others."""

    figure: Figure
    name: str

    def in_form(self, form: Format) -> bytes:
        """Its bytes as PNG or SVG."""
        buffer = BytesIO()
        with drawing(), mpl.rc_context({"svg.hashsalt": self.name}):
            self.figure.savefig(buffer, format=form.value, **_SAVED[form])
        return buffer.getvalue()

    def save(self, path: Path | str) -> Path:
        """Write a file, by its ending. InputError for one that is neither .png nor .svg."""
        file = Path(path)
        form = next((form for form in _SAVED if file.suffix.lower() == f".{form.value}"), None)
        if form is None:
            raise InputError(str(file), "", None, "a name that ends in .png or .svg")
        file.write_bytes(self.in_form(form))
        return file

    def _repr_png_(self) -> bytes:
        """What a notebook shows."""
        return self.in_form(Format.PNG)
