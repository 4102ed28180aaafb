"""Hiragana as Hepburn letters, so that a list of romanised names finds the stations of a source in Japanese."""

from __future__ import annotations

from typing import Final

_ROWS: Final = {
    "": "あいうえお",
    "k": "かきくけこ",
    "g": "がぎぐげご",
    "s": "さしすせそ",
    "z": "ざじずぜぞ",
    "t": "たちつてと",
    "d": "だぢづでど",
    "n": "なにぬねの",
    "h": "はひふへほ",
    "b": "ばびぶべぼ",
    "p": "ぱぴぷぺぽ",
    "m": "まみむめも",
    "r": "らりるれろ",
}
_OTHERS: Final = {
    "や": "ya", "ゆ": "yu", "よ": "yo", "わ": "wa", "を": "o", "ん": "n",
    "し": "shi", "じ": "ji", "ち": "chi", "ぢ": "ji", "つ": "tsu", "づ": "zu", "ふ": "fu", "ー": "",
}  # fmt: skip
_LETTERS: Final = {
    kana: head + vowel for head, row in _ROWS.items() for kana, vowel in zip(row, "aiueo", strict=True)
} | _OTHERS
_SMALL: Final = {"ゃ": "ya", "ゅ": "yu", "ょ": "yo"}


def romanised(kana: str) -> str:
    """Hepburn letters of hiragana, long vowels written out; anything else stays as it is."""
    text = ""
    doubled = False
    for sign in kana:
        if sign == "っ":
            doubled = True
            continue
        if sign in _SMALL and text.endswith("i"):
            text = text[:-1] + (_SMALL[sign][1:] if text.endswith(("shi", "ji", "chi")) else _SMALL[sign])
            continue
        letters = _LETTERS.get(sign, sign)
        if doubled and letters:
            text += "t" if letters.startswith("ch") else letters[0]
        doubled = False
        text += letters
    return text
