"""Labels and sentences in both languages: the code says them in English, `ja.po` has them in Japanese.

The catalogue is a gettext file, which Babel reads. Its context parts homonyms ("from" a place, "from" a time), and
names lists whose English stands elsewhere: values of enums (`cause`, `telegram`), sentences of files (`assumption`).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Final

from babel.messages.pofile import read_po

from study.wording.phrase import Phrase

CATALOGUE: Final = "ja.po"


def phrase(english: str, context: str = "") -> Phrase:
    """Words of the code in both languages. LookupError where the catalogue has none."""
    found = phrases_of(context).get(english)
    if found is None:
        raise LookupError(f"{CATALOGUE} has no Japanese for {english!r} in the context {context!r}")
    return found


def phrase_or_name(text: str, context: str = "") -> Phrase:
    """The same of a text that may be a name, which is the same in both languages."""
    return phrases_of(context).get(text) or Phrase(text)


def phrases_of(context: str) -> Mapping[str, Phrase]:
    """What a context has, by its English, in the order of the catalogue; empty where there is no such context."""
    return _by_context().get(context, {})


@cache
def _by_context() -> Mapping[str, Mapping[str, Phrase]]:
    found: dict[str, dict[str, Phrase]] = {}
    with (files("study") / "wording" / CATALOGUE).open("rb") as file:
        for message in read_po(file, locale="ja", abort_invalid=True):
            if message.id:
                english = str(message.id)
                found.setdefault(message.context or "", {})[english] = Phrase(english, str(message.string))
    return found
