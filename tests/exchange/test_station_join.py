"""Names that are the same to a reader join; what fits two stations, or none, is said."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exchange.published import PublishedStation
from exchange.station_join import JoinedBy, join_stations, names_by_hand
from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.making.station_names import spellings
from network.model import Line

LINE = load_line(shipped_line("karasuyama"))
NAMES = ["Hoshakuji", "Shimotsuke-Hanaoka", "Niita", "Konoyama", "Ogane", "Kobana", "Taki", "Karasuyama"]
JAPANESE = ["宝積寺", "下野花岡", "仁井田", "鴻野山", "大金", "小塙", "滝", "烏山"]
IDS = ["HSK", "SHN", "NIT", "KNY", "OGN", "KBN", "TAK", "KRS"]


def _source(names: list[str]) -> list[PublishedStation]:
    return [PublishedStation(f"s{i}", name) for i, name in enumerate(names)]


def _ids(names: list[str], line: Line = LINE, **options: object) -> list[str | None]:
    joined = join_stations("times.oud", _source(names), line, **options)  # type: ignore[arg-type]
    return [row.station_id for row in joined.rows]


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("Ogane", "Ōgane"),
        ("Ogane", "Ougane"),
        ("Ogane", "OOGANE"),
        ("Ogane", "Ohgane"),
        ("Ogane", "Ogane Station"),
        ("Ogane", "Ogane Sta."),
        ("Shimotsuke-Hanaoka", "shimotsuke hanaoka"),
        ("Shimotsuke-Hanaoka", "ShimotsukeHanaoka"),
        ("Shimbashi", "Shin-bashi"),
        ("Kyūhōji", "Kyuhoji"),
        ("Śródmieście WKD", "Srodmiescie WKD"),
        ("大金", "大金駅"),
        ("大金", "大 金"),
        ("滝", "瀧"),
        ("茅ヶ崎", "茅ケ崎"),
        ("茅ヶ崎", "茅が崎"),
        ("西ノ宮", "西の宮"),
        ("四ツ谷", "四ッ谷"),
        ("ﾃｸﾉさかき", "テクノさかき"),
        ("上総亀山(千葉)", "上総亀山（千葉）"),
    ],
)
def test_spellings_of_one_name_are_the_same(one: str, other: str) -> None:
    assert spellings(one)[0] == spellings(other)[0]


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("Ohara", "Oara"),
        ("Otaki", "Taki"),
        ("大滝", "滝"),
        ("小浜", "東小浜"),
        ("Obama", "Higashi-Obama"),
        ("滝", "滝信号場"),
    ],
)
def test_other_names_stay_others(one: str, other: str) -> None:
    assert not set(spellings(one)) & set(spellings(other))


@given(st.text())
def test_any_name_has_spellings_that_are_their_own(name: str) -> None:
    for spelling in spellings(name):
        assert spelling
        assert spelling in spellings(spelling)


@pytest.mark.parametrize(("names", "by"), [(NAMES, JoinedBy.ROMANISED), (JAPANESE, JoinedBy.JAPANESE)])
def test_all_stations_join_by_either_name(names: list[str], by: JoinedBy) -> None:
    joined = join_stations("times.oud", _source(names), LINE)
    assert [row.station_id for row in joined.rows] == IDS
    assert {row.by for row in joined.rows} == {by}
    assert not joined.missing
    assert not joined.reversed_order


def test_a_source_may_run_against_the_kilometrage() -> None:
    joined = join_stations("times.oud", _source(JAPANESE[::-1]), LINE)
    assert [row.station_id for row in joined.rows] == IDS[::-1]
    assert joined.reversed_order


def test_stations_beyond_the_line_are_left_and_said() -> None:
    joined = join_stations("times.oud", _source(["宇都宮", "岡本", *JAPANESE]), LINE)
    assert [row.station_id for row in joined.rows] == [None, None, *IDS]
    assert str(joined.rows[0]) == "宇都宮: not joined"
    assert str(joined.rows[2]) == "宝積寺 = HSK (Japanese name)"


def test_what_the_source_lacks_is_named() -> None:
    joined = join_stations("times.oud", _source([name for name in JAPANESE if name != "大金"]), LINE)
    assert joined.missing == ("OGN",)


def test_a_misspelt_station_is_not_joined_but_its_like_is_named() -> None:
    joined = join_stations("times.oud", _source(["Hoshakuji", "Nita", *NAMES[3:]]), LINE)
    assert joined.rows[1].station_id is None
    assert joined.rows[1].near == ("NIT",)


def test_names_that_fit_nothing_are_refused_with_what_is_like_them() -> None:
    with pytest.raises(InputError, match=r"0 of 3 joined.*Karasuyma \(like KRS\), Tokyo, Osaka"):
        _ids(["Tokyo", "Karasuyma", "Osaka"])


def test_few_that_fit_are_refused_but_not_when_said_by_hand() -> None:
    names = ["宝積寺", "烏山", *(f"別{i}" for i in range(9))]
    with pytest.raises(InputError, match="2 of 11 joined"):
        _ids(names)
    assert _ids(names, by_hand={"烏山": "KRS"})[:2] == ["HSK", "KRS"]


def test_a_part_of_the_line_is_enough() -> None:
    assert _ids(JAPANESE[4:6]) == ["OGN", "KBN"]


def test_an_order_that_the_kilometrage_contradicts_is_refused() -> None:
    names = [*JAPANESE[:3], "大金", "鴻野山", *JAPANESE[5:]]
    with pytest.raises(
        InputError, match=r"'鴻野山'; expected a station on the other side of OGN \(km 12.600\)"
    ):
        _ids(names)
    assert _ids(names, in_order=False)[3:5] == ["OGN", "KNY"]


def test_a_station_listed_twice_at_a_junction_is_one() -> None:
    assert _ids([*JAPANESE[:5], "支線", "大金", *JAPANESE[5:]]) == [*IDS[:5], None, "OGN", *IDS[5:]]


def test_two_names_cannot_be_one_station() -> None:
    source = [PublishedStation("a", "Ogane"), PublishedStation("b", "別", "大金"), *_source(NAMES[5:])]
    with pytest.raises(InputError, match=r"'別'; expected a station other than OGN, which Ogane is"):
        join_stations("times.oud", source, LINE)


def test_names_of_one_station_that_fit_two_are_refused() -> None:
    source = [PublishedStation("a", "Ogane", "滝"), *_source(NAMES[5:])]
    with pytest.raises(InputError, match="fits one station of the line, not TAK and OGN"):
        join_stations("times.oud", source, LINE)


def test_an_id_joins_unless_the_names_contradict_it() -> None:
    source = [PublishedStation("HSK", ""), PublishedStation("KRS", "")]
    assert [row.by for row in join_stations("s", source, LINE).rows] == [JoinedBy.ID, JoinedBy.ID]
    source = [PublishedStation("TAK", "Takasaki"), *_source(NAMES)]
    joined = join_stations("s", source, LINE)
    assert (joined.rows[0].station_id, joined.rows[7].station_id) == (None, "TAK")


def test_by_hand_counts_before_names_and_may_leave_out() -> None:
    names = ["Hoshakuji", "Hanaoka Crossing", *NAMES[2:]]
    assert _ids(names, by_hand={"Hanaoka Crossing": "SHN"}) == IDS
    assert _ids(names, by_hand={"Taki": "-"}) == ["HSK", None, *IDS[2:6], None, "KRS"]
    with pytest.raises(InputError, match="Hanaoka is 'XYZ'; expected one of HSK"):
        _ids(["Hanaoka", *NAMES], by_hand={"Hanaoka": "XYZ"})
    with pytest.raises(InputError, match="Nowhere; expected a station of the source"):
        _ids(NAMES, by_hand={"Nowhere": "HSK"})


def test_names_by_hand_come_from_a_file_and_from_options(tmp_path: Path) -> None:
    file = tmp_path / "names.toml"
    file.write_text('"大金駅前" = "OGN"\n"Taki" = "-"\n', "utf-8")
    assert names_by_hand(["Taki=TAK", "a=b=HSK"], file) == {"大金駅前": "OGN", "Taki": "TAK", "a=b": "HSK"}
    with pytest.raises(InputError, match="command line: --name is 'Taki'; expected SOURCE=ID"):
        names_by_hand(["Taki"])
    file.write_text("Taki = 3\n", "utf-8")
    with pytest.raises(InputError, match="Taki is 3; expected the id of a station"):
        names_by_hand([], file)
