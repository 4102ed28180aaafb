"""Every deliberate mistake can still be planted; `make nightly` plants them all."""

from collections import Counter
from typing import Final

import pytest

from tests.planted.__main__ import unnoticed_of
from tests.planted.defects import ROOT, planted

PART: Final = 20  # of a test: some minutes


def test_every_one_can_be_planted() -> None:
    for defect in planted():
        sound = (ROOT / defect.file).read_text("utf-8")
        assert defect.planted_in(sound) != sound, defect.what
        assert all((ROOT / path.partition("::")[0]).exists() for path in defect.tests), defect.what


def test_there_are_mistakes_of_every_kind_and_none_twice() -> None:
    kinds = Counter(defect.kind for defect in planted())
    assert sum(kinds.values()) >= 60
    assert set(kinds) == {"safety", "physics", "figures", "labels", "units"}
    assert len({defect.what for defect in planted()}) == len(planted())


@pytest.mark.nightly
@pytest.mark.parametrize("first", range(0, len(planted()), PART))
def test_every_one_is_noticed(first: int) -> None:
    assert unnoticed_of(planted()[first : first + PART]) == []
