"""Sentences that files and journals hold, found again by their forms: `{}` stands for a name or a figure."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from study.wording.phrase import Phrase


def phrase_by_form(forms: Iterable[Phrase], text: str, said: Callable[[str], Phrase]) -> Phrase | None:
    """The form that a text is made by, with what stands in it said by `said`; None where it is made by none."""
    for form in forms:
        values = _values(form.en, text)
        if values is not None:
            words = [said(value) for value in values]
            return Phrase(
                form.en.format(*(w.en for w in words)), form.ja.format(*(w.in_("ja") for w in words))
            )
    return None


def _values(form: str, text: str) -> list[str] | None:
    """What stands in a text where its form has `{}`."""
    parts, values = form.split("{}"), list[str]()
    if not text.startswith(parts[0]):
        return None
    at = len(parts[0])
    for number, part in enumerate(parts[1:], 2):
        last = number == len(parts)
        end = len(text) - len(part) if last else text.find(part, at)
        if end < at or not text.startswith(part, end):
            return None
        values.append(text[at:end])
        at = end + len(part)
    return values if at == len(text) else None
