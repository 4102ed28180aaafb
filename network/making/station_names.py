"""What two spellings of a station's name have in common: how people write the same name in different files.

Romanised names lose case, marks, spaces and the ways to write a long vowel (ō, ou, oo, oh); Japanese ones the forms of
a character (ヶ and ケ, 瀧 and 滝) and of a script. A word that only says what it is (駅, Station) is dropped from both.
Two stations whose names become the same are not told apart by them: who joins by these must look for that.
"""

from __future__ import annotations

import re
import unicodedata
from typing import Final

_WORDS: Final = re.compile(
    r"(?:[\s.,_-]+(?:railway\s+)?(?:station|stn|sta|stop|halt|eki)\.?)+$", re.IGNORECASE
)
_JAPANESE_WORDS: Final = re.compile(r"(?<=.)(?:停留場|停留所|駅|驛)$")
_BRACKETS: Final = re.compile(r"\([^()]*\)|\[[^\[\]]*\]|〔[^〔〕]*〕|【[^【】]*】|<[^<>]*>")
_NOT_A_LETTER: Final = re.compile(r"[\W_]+")
_LONG_VOWELS: Final = (
    (re.compile(r"o(?:u|o|h(?![aiueoy]))+"), "o"),
    (re.compile(r"uu+"), "u"),
    (re.compile(r"m(?=[bmp])"), "n"),  # Shimbashi, Shinbashi
)
_LATIN: Final = str.maketrans({"ł": "l", "ø": "o", "đ": "d", "ı": "i"})
# Forms of one character that names of stations are written with; the second is the one that newer files use.
_FORMS: Final = str.maketrans(
    dict(
        zip(
            "瀧龍澤濱邊邉嶋嶌廣國櫻髙﨑嵜澁氣驛條縣學壽惠眞應圓莊藏鐵豐瀨邨埜舘冨槇籠辯樂櫛",
            "滝竜沢浜辺辺島島広国桜高崎崎渋気駅条県学寿恵真応円荘蔵鉄豊瀬村野館富槙篭弁楽櫛",
            strict=True,
        )
    )
    | {"之": "の", "乃": "の", "ゖ": "が", "け": "が", "っ": "つ", "ゃ": "や", "ゅ": "ゆ", "ょ": "よ"}
)
_KATAKANA: Final = {code: code - 0x60 for code in range(0x30A1, 0x30F7)}


def is_japanese(text: str) -> bool:
    """Whether a name has a character of Japanese in it."""
    return any("\u3040" <= c <= "\u30ff" or "\u4e00" <= c <= "\u9fff" or c in "々〆" for c in text)


def spellings(name: str) -> tuple[str, ...]:
    """A name as it is compared, the most faithful spelling first: with what stands in brackets, then without it."""
    text = unicodedata.normalize("NFKC", name).strip()
    without = _BRACKETS.sub("", text).strip()
    found = (_plain(text), *((_plain(without),) if without and without != text else ()))
    return tuple(dict.fromkeys(spelling for spelling in found if spelling))


def _plain(text: str) -> str:
    return _plain_japanese(text) if is_japanese(text) else _plain_latin(text)


def _plain_japanese(text: str) -> str:
    short = _JAPANESE_WORDS.sub("", _WORDS.sub("", text))
    folded = _NOT_A_LETTER.sub("", short).translate(_KATAKANA).translate(_FORMS)
    return folded.casefold()


def _plain_latin(text: str) -> str:
    short = _WORDS.sub("", text) or text
    letters = unicodedata.normalize("NFKD", short.casefold().translate(_LATIN))
    plain = _NOT_A_LETTER.sub("", "".join(letter for letter in letters if not unicodedata.combining(letter)))
    for pattern, sound in _LONG_VOWELS:
        plain = pattern.sub(sound, plain)
    return plain
