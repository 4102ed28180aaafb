"""Every deliberate mistake can still be planted; `make nightly` plants them all."""

from collections import Counter

import pytest

from tests.planted.__main__ import main
from tests.planted.defects import ROOT, planted


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
def test_every_one_is_noticed() -> None:
    assert main([]) == 0
