"""`branchline import oudia` and `export oudia`: what a planner types, and what comes of it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from network.files.shipped import shipped_timetable

FOLDER = Path(__file__).resolve().parents[2] / "../shared/data/timetables/oudia"
needs_shared = pytest.mark.skipif(
    not FOLDER.exists(), reason="the timetable data is not beside this checkout"
)

Main = Callable[..., Any]


@pytest.fixture
def exported(main: Main, tmp_path: Path) -> Path:
    """The Karasuyama weekday as an OuDiaSecond file."""
    out = tmp_path / "day.oud2"
    assert main("export", "oudia", "karasuyama_weekday", str(out)).code == 0
    return out


@needs_shared
@pytest.mark.parametrize(("name", "stations", "trains"), [("obama.oud", 29, 81), ("utsube.oud", 10, 150)])
def test_a_file_is_counted_without_a_line(main: Main, name: str, stations: int, trains: int) -> None:
    """29 stations and 81 trains, and 150 trains: what is known of these files."""
    ended = main("import", "oudia", str(FOLDER / name), "--json")
    assert ended.code == 0
    figures = ended.figures()
    assert (figures["stations"], figures["trains"]) == (stations, trains)
    told = main("import", "oudia", str(FOLDER / name))
    assert f"stations: {stations}\ntrains: {trains}\n" in told.out


def test_what_is_exported_is_imported_as_it_was(main: Main, exported: Path, tmp_path: Path) -> None:
    out = tmp_path / "again.toml"
    ended = main("import", "oudia", str(exported), str(out), "--line", "karasuyama", "--json")
    assert ended.code == 0, ended.err
    assert ended.figures()["sets"] == 4
    shipped = shipped_timetable("karasuyama_weekday").read_text("utf-8")
    assert out.read_text("utf-8") == shipped


def test_another_id_is_taken(main: Main, exported: Path, tmp_path: Path) -> None:
    out = tmp_path / "again.toml"
    main("import", "oudia", str(exported), str(out), "--line", "karasuyama", "--id", "mine")
    assert out.read_text("utf-8").startswith('[timetable]\nid = "mine"\n')


def test_a_file_that_was_changed_is_read_as_any_other(main: Main, exported: Path, tmp_path: Path) -> None:
    data = exported.read_bytes().replace(b"Operation0B=4/0$537/$/V2\r\n", b"", 1)
    exported.write_bytes(data)
    out = tmp_path / "again.toml"
    ended = main("import", "oudia", str(exported), str(out), "--line", "karasuyama")
    assert ended.code == 0, ended.err
    assert "read as any other file: it was written by branchline, but train 321M does not run" in ended.err
    assert "station: 宝積寺 = HSK (Japanese name)" in ended.out
    assert 'number = "321M"' in out.read_text("utf-8")


def test_another_line_has_other_stations(main: Main, exported: Path) -> None:
    ended = main("import", "oudia", str(exported), "--line", "rtri_test_line", "--json")
    assert ended.code == 2
    assert "0 of 8 joined" in ended.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("{day}", "{out}"), "--line; expected the line of the timetable file"),
        (("{day}", "{out}", "--line", "karasuyama", "--dia", "土曜"), "expected one of its names (--dia)"),
        (("{day}", "{out}", "--line", "karasuyama", "--name", "Ogane"), "expected SOURCE=ID"),
        (("{day}", "{out}", "--line", "karasuyama", "--id", "a b"), "expected an identifier"),
        (("{day}", "{out}", "--line", "nowhere"), "nowhere; expected a .toml file or a shipped line"),
        (("{foreign}",), "expected an OuDia file, whose first line is"),
        (("{cut}",), "expected a whole file: it breaks off"),
        (("{missing}",), "expected a readable file"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(
    main: Main, exported: Path, tmp_path: Path, arguments: tuple[str, ...], message: str
) -> None:
    names = {name: tmp_path / name for name in ("foreign", "cut", "missing", "out")}
    names["foreign"].write_text("Line,Station\n", "utf-8")
    names["cut"].write_bytes(exported.read_bytes()[:5000])
    before = sorted(tmp_path.iterdir())
    ended = main("import", "oudia", *(text.format(day=exported, **names) for text in arguments))
    assert ended.code == 2
    assert message in ended.err
    assert ended.err.startswith("error: ")
    assert ended.err.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before


def test_an_export_of_nothing_writes_nothing(main: Main, tmp_path: Path) -> None:
    for source in ("nowhere", str(tmp_path)):
        ended = main("export", "oudia", source, str(tmp_path / "day.oud2"))
        assert ended.code == 2
        assert ended.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
    ended = main("export", "oudia", "karasuyama_weekday", str(tmp_path / "no" / "day.oud2"))
    assert ended.code == 2
