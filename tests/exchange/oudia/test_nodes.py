"""A file is kept as it is, down to keys that nobody here knows; a file that is none gets one message."""

import codecs
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exchange.oudia.nodes import OudiaEntry, OudiaNode, OudiaText, entry, parse_oudia, read_oudia
from exchange.oudia.route import route_of
from exchange.oudia.writer import oudia_of
from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.timetable import load_timetable

FOLDER = Path(__file__).resolve().parents[3] / "../shared/data/timetables/oudia"
needs_shared = pytest.mark.skipif(
    not FOLDER.exists(), reason="the timetable data is not beside this checkout"
)
REAL = ["obama.oud", "utsube.oud"]

LINE = load_line(shipped_line("karasuyama"))
WRITTEN = oudia_of(LINE, load_timetable(shipped_timetable("karasuyama_weekday"), LINE)).encoded()

names = st.from_regex(r"[A-Z][A-Za-z0-9]{0,8}", fullmatch=True)
# with characters that end in the byte of a backslash
in_cp932 = st.text(st.sampled_from("abc=.;,/$\\\n 駅十ソ表能予―Ⅸ噂申貼・ーア村"), max_size=12)
any_text = st.text(st.characters(exclude_categories=("Cs", "Cc"), include_characters="\n"), max_size=12)


def trees(values: st.SearchStrategy[str]) -> st.SearchStrategy[OudiaNode]:
    lines = st.builds(entry, names, values)
    nodes = st.recursive(
        st.builds(OudiaNode, names, st.lists(lines, max_size=3).map(tuple)),
        lambda inner: st.builds(OudiaNode, names, st.lists(lines | inner, max_size=4).map(tuple)),
        max_leaves=12,
    )
    return st.lists(lines | nodes, max_size=4).map(tuple).map(lambda items: OudiaNode("", items))


def _with_type(root: OudiaNode, kind: str) -> OudiaNode:
    return OudiaNode("", (entry("FileType", kind), *root.items))


@given(trees(any_text), st.sampled_from(["\n", "\r\n"]))
def test_a_file_in_utf8_is_read_and_written_the_same(root: OudiaNode, newline: str) -> None:
    text = OudiaText(_with_type(root, "OuDiaSecond.1.10"), utf8=True, newline=newline)
    data = text.encoded()
    again = parse_oudia(data, "a.oud2")
    assert again.encoded() == data
    assert again.root == text.root


@given(trees(in_cp932))
def test_a_file_in_cp932_is_read_and_written_the_same(root: OudiaNode) -> None:
    plain = OudiaText(_with_type(root, "OuDia.1.02"), utf8=False)
    data = plain.encoded()
    again = parse_oudia(data, "a.oud")
    assert again.encoded() == data


@given(in_cp932)
def test_oudia_doubles_each_byte_of_a_backslash(value: str) -> None:
    """As OuDia writes a value: byte by byte, so that 十, 0x8F 0x5C, has one more behind it."""
    written = value.encode("cp932").replace(b"\\", b"\\\\").replace(b"\n", b"\\n")
    data = b"FileType=OuDia.1.01\nComment=" + written + b"\nTail=x\n"
    if data.isascii() or not _sure(data):
        return
    assert parse_oudia(data, "a.oud").root.text("Comment") == value


def _sure(data: bytes) -> bool:
    """Whether the text is long enough to be told from another encoding."""
    try:
        parse_oudia(data, "a.oud")
    except InputError:
        return False
    return True


@needs_shared
@pytest.mark.parametrize("name", REAL)
def test_a_real_file_is_written_again_byte_for_byte(name: str) -> None:
    assert read_oudia(FOLDER / name).encoded() == (FOLDER / name).read_bytes()


@needs_shared
def test_a_name_of_a_real_file_has_no_backslash() -> None:
    rosen = read_oudia(FOLDER / "obama.oud").root.node("Rosen")
    assert rosen is not None
    assert rosen.nodes("Eki")[20].text("Ekimei") == "十村"


def test_unknown_keys_and_nodes_are_kept_in_their_places() -> None:
    data = (
        b"\xef\xbb\xbfFileType=OuDiaSecond.1.99\r\nFuture=1\r\nRosen.\r\nNew.\r\nA=\\\\x\\n\r\n\r\n.\r\nOdd line\r\n"
        b"Future=2\r\n.\r\nFuture=3\r\n"
    )
    text = parse_oudia(data, "a.oud2")
    assert text.encoded() == data
    rosen = text.root.node("Rosen")
    assert rosen is not None
    assert [one.value for one in text.root.entries("Future")] == ["1", "3"]
    assert rosen.text("Future") == "2"
    assert rosen.items[1] == OudiaEntry("Odd line", None)
    new = rosen.node("New")
    assert new is not None
    assert new.text("A") == "\\x\n"


UTF8 = codecs.BOM_UTF8
SHORT = "FileType=OuDiaSecond.1.10\nRosen.\nRosenmei=烏山線の平日の時刻表\n.\n"


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "expected an OuDia file, whose first line is FileType="),
        (b"PK\x03\x04", "expected an OuDia file"),
        (b'{"trains": []}', "expected an OuDia file"),
        (b"[Line]\nWinDIA\n", "expected an OuDia file"),
        (
            b"FileType=OuDiaThird.1.0\n",
            "FileType is 'OuDiaThird.1.0'; expected OuDia.1.xx or OuDiaSecond.1.xx",
        ),
        (b"FileType=OuDia.2.00\n", "FileType is 'OuDia.2.00'"),
        (b"FileType=OuDia.1.02\nA=\0\n", "without the zero byte in line 2"),
        (SHORT.encode("utf-16"), "not in UTF-16"),
        (SHORT.encode("utf-16-le"), "not in UTF-16"),
        (SHORT.encode("utf-8"), "it is in UTF-8 without"),
        (SHORT.encode("cp932"), "in UTF-8 with its mark at the front (BOM), but it is in Shift-JIS"),
        (SHORT.encode("euc_jp"), "but it is in EUC-JP; convert it"),
        (UTF8 + SHORT.encode("cp932"), "text in UTF-8 (byte 0x89 in line 3 is none)"),
        (UTF8 + SHORT.encode()[:-3], "a whole file: it breaks off in Rosen, which begins in line 2"),
        (UTF8 + SHORT.encode()[:-17], "a whole file: it breaks off in the middle of a character (line 3)"),
        (UTF8 + SHORT.encode() + b".\n", "line 5 is '.'; expected no end of a node here: none is open"),
        (b"FileType=OuDia.1.02\n" + b"A.\n" * 99, "nodes at most 8 deep"),
        (b"FileType=OuDia.1.02\n", "Rosen; expected a route, which is missing"),
        (b"FileType=OuDia.1.02\nRosen.\n.\n", "DispProp; expected the display settings"),
        (b"FileType=OuDia.1.02\nRosen.\n.\nDispProp.\n.\n", "Rosen.Eki; expected stations"),
        (
            b"FileType=OuDia.1.02\nRosen.\nEki.\n.\n.\nDispProp.\n.\n",
            "Rosen.Dia; expected at least one timetable",
        ),
        (
            b"FileType=OuDia.1.02\nRosen.\nEki.\n.\nDia.\nDiaName=a\nKudari.\n.\n.\n.\nDispProp.\n.\n",
            "Dia 'a'; expected Nobori, its trains of that direction",
        ),
    ],
)
def test_what_is_no_file_of_oudia_gets_one_message(data: bytes, message: str) -> None:
    with pytest.raises(InputError) as error:
        route_of(parse_oudia(data, "day.oud"), "day.oud")
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@needs_shared
@pytest.mark.parametrize("encoding", ["utf-8", "euc_jp", "utf-16", "utf-8-sig"])
@pytest.mark.parametrize("name", REAL)
def test_a_real_file_in_another_encoding_is_named_as_that(name: str, encoding: str) -> None:
    text = (FOLDER / name).read_bytes().decode("cp932")
    data = text.encode(encoding, errors="replace")
    if encoding == "utf-8-sig":  # which tells itself
        assert len(route_of(parse_oudia(data, name), name).stations) in (10, 29)
        return
    with pytest.raises(InputError, match=r"UTF-8|EUC-JP|UTF-16"):
        parse_oudia(data, name)


def test_a_file_without_a_last_end_of_line_is_written_without_one() -> None:
    data = b"FileType=OuDia.1.02\nRosen.\n."
    assert parse_oudia(data, "a.oud").encoded() == data


@given(st.data())
def test_a_file_that_breaks_off_is_never_read_as_whole(data: st.DataObject) -> None:
    whole = WRITTEN.rindex(b"\r\n.\r\n") + 3  # all but what stands behind the last node
    length = data.draw(st.integers(0, whole - 1) | st.integers(whole - 40, whole - 1))
    with pytest.raises(InputError):
        route_of(parse_oudia(WRITTEN[:length], "cut.oud2"), "cut.oud2")


@given(st.data())
def test_a_damaged_file_is_read_or_refused(data: st.DataObject) -> None:
    damaged = bytearray(WRITTEN)
    for _ in range(data.draw(st.integers(1, 5))):
        at = data.draw(st.integers(0, len(WRITTEN) - 1))
        damaged[at] = data.draw(st.integers(0, 255) | st.sampled_from(b"0123456789.;/$,=\n"))
    try:
        route = route_of(parse_oudia(bytes(damaged), "bad.oud2"), "bad.oud2")
    except InputError as error:
        assert "\n" not in str(error)
        return
    from exchange.onto_line import onto_line
    from exchange.oudia.exact import read_back
    from exchange.oudia.published import published_of

    for dia in route.dias:
        read_back(route, dia, LINE)
        try:
            onto_line(published_of(route, dia), LINE)
        except InputError as error:
            assert "\n" not in str(error)
