"""Ways to cut a line: what belongs to which part."""

import pytest

from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import SectionKind
from study.capacity.cut import WAYS, PartKind, cut_of

KARASUYAMA = load_line(shipped_line("karasuyama"))
BUSY = load_line(shipped_line("busy_line"))


def parts(line_name: str, way: str) -> dict[str, set[str]]:
    line = {"karasuyama": KARASUYAMA, "busy_line": BUSY}[line_name]
    return {part.name: set(part.section_ids) for part in cut_of(line, way).parts}


def test_karasuyama_in_four_ways() -> None:
    whole = {s.id for s in KARASUYAMA.sections.values() if s.kind is not SectionKind.PORTAL}
    assert parts("karasuyama", "whole") == {"Hoshakuji - Karasuyama": whole}
    assert parts("karasuyama", "crossing") == {
        "Hoshakuji - Ogane": {"HSK.1", "HSK-OGN", "OGN.W"},
        "Ogane - Karasuyama": {"OGN.E", "OGN-KRS", "KRS.1"},
    }
    assert parts("karasuyama", "interval") == {
        "Hoshakuji - Ogane": {"HSK-OGN", "OGN.W"},
        "Ogane - Karasuyama": {"OGN.E", "OGN-KRS"},
        "Hoshakuji": {"HSK.1", "HSK.S"},
        "Ogane": {"OGN.1", "OGN.2", "OGN.W", "OGN.E"},
        "Karasuyama": {"KRS.1"},
    }
    assert set(parts("karasuyama", "section")) == whole


@pytest.mark.parametrize("way", sorted(WAYS))
def test_every_section_is_in_a_part_and_no_portal_is(way: str) -> None:
    cut = cut_of(BUSY, way)
    inside = {one for part in cut.parts for one in part.section_ids}
    portals = {s.id for s in BUSY.sections.values() if s.kind is SectionKind.PORTAL}
    assert not inside & portals
    if way != "crossing":  # whose line parts end where the tracks of a crossing station begin
        assert inside == set(BUSY.sections) - portals
    assert cut.how


def test_a_station_with_one_track_lies_within_a_stretch_between_crossing_stations() -> None:
    lines = [p for p in cut_of(BUSY, "crossing").parts if p.kind is PartKind.LINE]
    assert len(lines) == len(BUSY.stations) - 1


def test_another_word_is_bad_input() -> None:
    with pytest.raises(InputError, match="--cut"):
        cut_of(BUSY, "sideways")
