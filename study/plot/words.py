"""The words of pictures in Japanese: every text of a figure that is known is put into the language chosen."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.text import Text

from study.wording.catalogue import phrase_or_name, phrases_of
from study.wording.forms import phrase_by_form
from study.wording.phrase import Language


def plot_word(text: str, language: Language) -> str:
    """A text of a figure in a language; as it is where the catalogue does not have it."""
    known = phrases_of("").get(text) or phrase_by_form(phrases_of("picture").values(), text, phrase_or_name)
    return text if known is None else known.in_(language)


def translate(figure: Figure, language: Language) -> None:
    """Put every known text of a figure into a language."""
    for text in figure.findobj(Text):
        translated = plot_word(text.get_text(), language)
        if translated != text.get_text():
            text.set_text(translated)
