"""Every kind of plot of real runs, in both languages: written whole, the same each time, with no text cut."""

from dataclasses import replace
from itertools import pairwise, permutations, product
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import matplotlib as mpl
import polars as pl
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text

from network.errors import InputError
from study.measures.wait_text import at_time
from study.plot import stations
from study.plot.choice import Choice, chosen_run, time_of
from study.plot.days import CAUSE_COLOURS
from study.plot.kinds import KINDS, PlotKind, PlotOption, kind_of
from study.plot.words import plot_word
from study.plot.write import default_name, figure_of, format_of, write_plot
from study.record.read_back import RunRead, read_run
from study.record.tables import ROWS, RunTables
from study.record.wait import Cause
from study.report.drawn import DPI, Format
from study.report.energy import energy_tables
from study.report.style import drawing
from study.runner.run import write_run
from study.wording.catalogue import phrases_of
from study.wording.phrase import Language
from tests.nightly import others_nightly
from tests.plain import run_on_plain

BEGINNINGS = {Format.PNG: b"\x89PNG\r\n", Format.SVG: b"<?xml", Format.CSV: b"\xef\xbb\xbf"}
ON_BATTERIES = """
extends = "karasuyama_round_trip"
id = "karasuyama_round_trip"
name = "a round trip on a battery"

[battery]

[patch.line]
add.crossings = [
  { id = "C1", section = "HSK-OGN", km = 5.0, control = "contacts", start_down_km = 4.3, start_up_km = 5.7 },
]
"""
OF_ONE_TRAIN = {"rtri_test_line": ("T1", "A"), "karasuyama_round_trip": ("321M", "OGN")}


@pytest.fixture(
    scope="session",
    params=[pytest.param("rtri_test_line", marks=pytest.mark.nightly), "karasuyama_round_trip"],
)
def read(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> RunRead:
    made = tmp_path_factory.mktemp("plots")
    scenario = request.param
    if scenario == "karasuyama_round_trip":
        scenario = str(made / "on_batteries.toml")
        Path(scenario).write_text(ON_BATTERIES, "utf-8")
    run = run_on_plain(scenario)
    folder = made / request.param
    write_run(run, folder)
    return read_run(folder)


def needed(read: RunRead, kind: PlotKind) -> tuple[str | None, str | None]:
    train, station = OF_ONE_TRAIN[str(read.settings.id)]
    return (
        train if PlotOption.TRAIN in kind.needs else None,
        station if PlotOption.STATION in kind.needs else None,
    )


def kind_for(read: RunRead, name: str) -> PlotKind:
    """The kind of plot, of a run that has something to show by it."""
    if name == "battery" and read.tables.battery.is_empty():
        pytest.skip("a run without batteries, which the other has")
    if name == "level-crossings" and read.tables.crossings.is_empty():
        pytest.skip("a run without level crossings, which the other has")
    if name == "headway":
        pytest.skip("runs of one set have no headways; tests/branchline/test_capacity_commands.py has two")
    return kind_of(name)


EVERY = pytest.mark.parametrize("name", list(KINDS))
IN_EVERY_RUN = {
    ("train-graph", Format.PNG),
    ("run-curve", Format.SVG),
    *((name, Format.CSV) for name in list(KINDS)[::2]),
}


@pytest.mark.parametrize(("name", "form"), others_nightly(product(KINDS, Format), IN_EVERY_RUN, columns=True))
def test_every_kind_is_written_the_same_each_time(
    read: RunRead, name: str, form: Format, tmp_path: Path
) -> None:
    kind = kind_for(read, name)
    train, station = needed(read, kind)
    choice = Choice(train, station, language="ja")
    for out in (tmp_path / "first", tmp_path / "second"):
        write_plot(read, kind, choice, form, out)
    data = (tmp_path / "first").read_bytes()
    assert data.startswith(BEGINNINGS[form])
    assert data == (tmp_path / "second").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["first", "second"]


@pytest.mark.parametrize("name", ["duties", "delays"])
def test_places_are_named_in_the_language_chosen(read: RunRead, name: str) -> None:
    station = read.line.stations[read.tables.stops["station"][-1]]
    names: dict[Language, str] = {"en": station.name, "ja": station.name_ja or station.name}
    for language, other in permutations(names):
        with drawing():
            figure = figure_of(chosen_run(read, Choice(language=language)), kind_of(name))
        labels = [text for axes in figure.axes for text in (*axes.texts, *axes.get_xticklabels())]
        texts = "\n".join(text.get_text() for text in labels)
        assert names[language] in texts
        assert names[other] in names[language] or names[other] not in texts


@pytest.mark.parametrize("name", ["energy-leg", "energy-parts", "margins"])
def test_legs_that_begin_or_end_together_stand_in_one_order(read: RunRead, name: str) -> None:
    """An express beside trains that call everywhere: the first leg from a station, and to it, is the shorter one."""
    if read.settings.id != "karasuyama_round_trip":
        pytest.skip("one train between two stations")
    table = "margins" if name == "margins" else "energy_legs"
    rows = getattr(read.tables, table)
    ends = next(
        (a, b, c)
        for (a, b), (_, c) in pairwise(
            rows.filter(pl.col("train") == read.timetable.diagrams[0].train_numbers[0])
            .select("from_station", "to_station")
            .rows()
        )
        if all(end in read.line.stations for end in (a, b, c))
    )
    express = rows.filter(pl.col("from_station") == ends[0], pl.col("to_station") == ends[1])[:1]
    more = pl.concat([express.with_columns(pl.lit(ends[2]).alias("to_station")), rows])
    changed = replace(read, tables=RunTables(**{n: getattr(read.tables, n) for n in ROWS} | {table: more}))
    legs = ["\n".join(read.line.stations[end].name for end in leg) for leg in pairwise(ends)]
    wanted = [legs[0], "\n".join(read.line.stations[end].name for end in ends[::2]), legs[1]]
    for _ in range(20):
        with drawing():
            figure = figure_of(chosen_run(changed, Choice()), kind_of(name))
        shown = [label.get_text() for axes in figure.axes for label in axes.get_xticklabels()]
        assert [label for label in shown if label in wanted] == wanted


def cut_texts(figure: Figure) -> list[str]:
    """Texts that reach beyond the picture, in its own dots; half a dot is the edge of a letter."""
    figure.dpi = DPI
    figure.draw_without_rendering()
    width, height = figure.bbox.width, figure.bbox.height
    cut: list[str] = []
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        if not text.get_visible() or not text.get_text().strip() or text.get_clip_on():
            continue
        box = text.get_window_extent()
        axes = text.axes
        if axes is not None and text in axes.get_xticklabels() + axes.get_yticklabels():
            low, high = sorted(axes.get_xlim() if text in axes.get_xticklabels() else axes.get_ylim())
            at = text.get_position()[0 if text in axes.get_xticklabels() else 1]
            if not low <= at <= high:
                continue  # a label that matplotlib keeps and does not draw
        if box.x0 < -1 or box.y0 < -1 or box.x1 > width + 1 or box.y1 > height + 1:
            cut.append(text.get_text())
    return cut


@pytest.mark.nightly
@EVERY
def test_no_text_of_a_picture_is_cut(read: RunRead, name: str) -> None:
    kind = kind_for(read, name)
    run = chosen_run(read, Choice(*needed(read, kind)))
    with drawing():
        assert not cut_texts(figure_of(run, kind))


@pytest.mark.parametrize("name", others_nightly(KINDS, list(KINDS)[::4]))
def test_nor_is_that_of_a_japanese_one_which_keeps_no_english_words(read: RunRead, name: str) -> None:
    kind = kind_for(read, name)
    run = chosen_run(read, Choice(*needed(read, kind), language="ja"))
    with drawing():
        figure = figure_of(run, kind)
        assert not cut_texts(figure)
    texts = {text.get_text() for text in figure.findobj(Text) if isinstance(text, Text)}
    assert not {text for text in texts if len(text) > 2} & set(phrases_of(""))
    labels = {axes.get_ylabel() for axes in figure.axes} | {axes.get_xlabel() for axes in figure.axes}
    legends = [*figure.legends, *(own for axes in figure.axes if (own := axes.get_legend()) is not None)]
    labels |= {text.get_text() for legend in legends for text in legend.get_texts()} - set(run.units)
    assert all(not label or any(ord(c) > 0x2E80 for c in label) for label in labels), labels
    assert any(ord(c) > 0x2E80 for c in kind.title.ja)


def test_a_text_of_a_picture_is_said_in_japanese_and_a_name_is_not() -> None:
    assert [plot_word(text, "ja") for text in ("mean 1 m", "down trains", "321M")] == [
        "平均 1 m",
        "下り列車",
        "321M",
    ]


def test_pictures_of_energy_and_margins_have_the_heights_of_their_tables(read: RunRead) -> None:
    """Bars against sums and means of the tables, dots left of a hop's middle as planned and right of it as run."""
    more = [read.tables.energy_legs.with_columns(pl.col("net_kwh") * times) for times in (1.0, 2.0, 6.0)]
    begins = pl.col("from_station").is_in(["HSK", "KRS"])  # the first hop of a way has nothing left
    left = read.tables.margins.with_columns(left_s=pl.when(~begins).then("left_s"))
    tables = replace(read.tables, energy_legs=pl.concat(more), margins=left)  # so that no mean is a median
    run = chosen_run(replace(read, tables=tables), Choice())
    kinds = map(kind_of, ("energy-hour", "energy-leg", "margins"))
    with drawing():
        hours, legs, margins = (figure_of(run, kind).axes for kind in kinds)
    tall = [(bars.get_label(), sum(bar.get_height() for bar in bars)) for bars in hours[0].containers]
    whole, runs = tables.energy_hours, pl.col("phase") == "running"
    parts = [whole["traction_kwh"], *(whole.filter(which)["auxiliary_kwh"] for which in (runs, ~runs))]
    sums = [*(part.sum() for part in parts), -whole["regenerated_kwh"].sum()]
    names = ("traction", "auxiliary, running", "auxiliary, standing", "regenerated")
    assert dict(tall) == pytest.approx(dict(zip(names, sums, strict=True)))
    means = tables.energy_legs.group_by("from_station", "to_station").agg(pl.col("net_kwh").mean())
    bars = [bar.get_height() for axes in legs for part in axes.containers for bar in part]
    assert sorted(bars) == pytest.approx(sorted(means["net_kwh"]))
    shown = {
        table.id: {c.label: c.values for c in table.columns} for table in energy_tables(run, read.summary)
    }
    assert sorted(shown["energy_parts_by_leg"]["net_kwh"]) == pytest.approx(sorted(means["net_kwh"]))
    dots = [at for axes in margins for line in axes.lines[:-1] for at in zip(*line.get_data(), strict=True)]
    for name, side in (("margin_s", -1), ("left_s", 1)):
        drawn = [y for x, y in dots if side * (x - round(x)) > 0.0]
        assert sorted(drawn) == pytest.approx(sorted(tables.margins[name].drop_nulls()))
    named = [[text.get_text() for text in axes.get_legend().get_texts()] for axes in margins]
    assert named == [["planned", "left on arrival, as run"]] * len(margins)


def test_a_stretch_of_time_is_all_that_is_shown(read: RunRead) -> None:
    if read.settings.id != "karasuyama_round_trip":
        return
    choice = Choice(from_s=6 * 3600.0, to_s=6.5 * 3600.0)
    run = chosen_run(read, choice)
    for name in ("waits", "track-occupation", "station-timetable"):
        table = kind_of(name).table(run)
        times = [c for c in table.columns if c.endswith("_s") and c not in ("since_s", "until_s")]
        latest, earliest = pl.max_horizontal(times), pl.min_horizontal(times)
        assert len(table)
        assert table.filter((latest < choice.from_s) | (earliest >= choice.to_s)).is_empty()
    with drawing():
        axes = figure_of(run, kind_of("train-graph")).axes[0]
    low, high = axes.get_xlim()
    assert (low, high) == (6 * 3600.0, 6.5 * 3600.0)


def colours_of(figure: Figure) -> dict[str, str]:
    """Of each set, by the legend, or by the line of its panel."""
    found = {
        axes.get_ylabel().split("\n")[0]: str(axes.lines[2].get_color())
        for axes in figure.axes
        if "charge" in axes.get_ylabel()
    }
    for legend in figure.legends if not found else ():
        patches, texts = legend.get_patches(), legend.get_texts()
        found |= {
            text.get_text(): to_hex(patch.get_facecolor()) for patch, text in zip(patches, texts, strict=True)
        }
    return found


@pytest.mark.parametrize("name", ["track-occupation", "battery"])
def test_a_set_keeps_its_colour_whatever_is_chosen(read: RunRead, name: str) -> None:
    """The first set has left the line when the second one turns."""
    if read.settings.id != "karasuyama_round_trip":
        pytest.skip("one train between two stations")
    kind = kind_for(read, name)
    first, second = sorted({d.stock_id for d in read.timetable.diagrams})
    gone_s = float(read.tables.trajectory.filter(pl.col("unit") == first)["t_s"][-1]) + 60.0
    with drawing():
        whole, part = (
            figure_of(chosen_run(read, choice), kind) for choice in (Choice(), Choice(from_s=gone_s))
        )
    assert colours_of(part)[second] == colours_of(whole)[second] != colours_of(whole)[first]
    if name == "battery":  # the set stands, and nothing is written down of it for a while
        panel = next(axes for axes in part.axes if axes.get_ylabel().startswith(second))
        assert panel.get_xlim()[0] == gone_s
        empty, reserve, charge = panel.lines[:3]
        assert charge.get_xdata()[0] <= gone_s
        assert empty.get_ydata()[0] < reserve.get_ydata()[0]
        assert (empty.get_linestyle(), reserve.get_linestyle()) == ("-", "--")


def test_whatever_is_waited_for_is_seen_and_blank_is_who_waits_for_nothing() -> None:
    assert set(CAUSE_COLOURS) == set(Cause) - {Cause.RUNS, Cause.OUTSIDE, Cause.LEFT}


def test_sentences_stand_in_the_table_of_waits(read: RunRead) -> None:
    for language, ends in (("en", "."), ("ja", "。")):
        table = kind_of("waits").table(chosen_run(read, Choice(language="ja" if language == "ja" else "en")))
        assert len(table)
        assert all(sentence.endswith(ends) for sentence in table["sentence"])


@pytest.mark.parametrize(
    ("kind", "choice", "key"),
    [
        ("train-graph", Choice(train="999"), "--train"),
        ("train-graph", Choice(station="NOWHERE"), "--station"),
        ("run-curve", Choice(), "--train"),
        ("station-timetable", Choice(), "--station"),
        ("duties", Choice(from_s=9e3), "--from, --to"),
        ("stop-errors", Choice(from_s=9 * 3600.0), "--from, --to"),
    ],
)
def test_a_choice_that_makes_no_sense_is_refused(
    read: RunRead, kind: str, choice: Choice, key: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as refused:
        write_plot(read, kind_of(kind), choice, Format.PNG, tmp_path / "none.png")
    assert refused.value.key == key
    assert not list(tmp_path.iterdir())


def test_trains_to_choose_from_stand_in_the_order_of_the_timetable(read: RunRead) -> None:
    with pytest.raises(InputError) as refused:
        chosen_run(read, Choice(train="999"))
    ran = set(read.tables.stops["train"])
    assert refused.value.expected == f"one of {', '.join(n for n in read.timetable.trains if n in ran)}"


def test_the_format_is_that_of_the_option_or_of_the_file() -> None:
    assert format_of(None, None) is Format.PNG
    assert format_of(None, Path("a.svg")) is Format.SVG
    assert format_of("csv", Path("a.svg")) is Format.CSV
    for name, out, key in (("pdf", None, "--format"), (None, Path("a.pdf"), "--out")):
        with pytest.raises(InputError) as refused:
            format_of(name, out)
        assert refused.value.key == key
        assert "png, svg, csv" in refused.value.expected


def test_a_time_that_is_none_and_a_kind_that_is_none() -> None:
    assert time_of("--from", "07:30") == 27000.0
    assert time_of("--from", None) is None
    with pytest.raises(InputError):
        time_of("--from", "7.30")
    with pytest.raises(InputError) as refused:
        kind_of("traingraph")
    assert all(name in refused.value.expected for name in KINDS)


def test_a_stretch_of_time_that_is_none_of_the_run_is_refused_as_typed(read: RunRead, tmp_path: Path) -> None:
    """Back to front; after the run, which would give an empty graph; before it."""
    begins_s, ends_s = chosen_run(read, Choice()).window_s
    whole = f"goes from {at_time(begins_s)} to {at_time(ends_s)}"
    for from_s, to_s, key, typed, why in (
        (36_000.0, 32_400.0, "--to", "09:00", "a time after --from, 10:00"),
        (36_000.0, 36_000.0, "--to", "10:00", "a time after --from, 10:00"),
        (90_000.0, 93_600.0, "--from", "25:00", whole),
        (90_000.0, None, "--from", "25:00", whole),
        (0.0, 60.0, "--to", "00:01", whole),
        (None, 60.0, "--to", "00:01", whole),
    ):
        with pytest.raises(InputError) as refused:
            choice = Choice(from_s=from_s, to_s=to_s)
            write_plot(read, kind_of("train-graph"), choice, Format.PNG, tmp_path / "a.png")
        assert (refused.value.key, refused.value.value) == (key, typed)
        assert why in refused.value.expected
    assert list(tmp_path.iterdir()) == []
    partly = chosen_run(read, Choice(from_s=begins_s - 60.0, to_s=begins_s + 60.0))
    assert partly.window_s == (begins_s - 60.0, begins_s + 60.0)


def test_the_name_of_a_file_says_what_it_shows() -> None:
    assert default_name(kind_of("run-curve"), Choice(train="321M"), Format.SVG) == "run-curve-321M.svg"


def test_settings_of_matplotlib_come_back(read: RunRead, tmp_path: Path) -> None:
    before = dict(mpl.rcParams)
    write_plot(read, kind_of("punctuality"), Choice(), Format.SVG, tmp_path / "a.svg")
    assert dict(mpl.rcParams) == before


def test_one_hop_is_drawn_of_several_runs_and_a_run_of_another_line_is_refused(read: RunRead) -> None:
    kind = kind_of("laws")
    train, station = OF_ONE_TRAIN[str(read.settings.id)]
    table = kind.table(chosen_run(read, Choice(train, station, beside=(read, read))))
    assert len(table) == 3 * len(kind.table(chosen_run(read, Choice(train, station))))
    with drawing():
        figure = figure_of(chosen_run(read, Choice(train, station, beside=(read,))), kind)
        assert not cut_texts(figure)
    assert len(figure.axes) == 4  # speed, gradient, and the notches of each
    names = {text.get_text() for legend in figure.legends for text in legend.get_texts()}
    energies = [name for name in names if "kWh" in name]
    assert len(energies) == 2  # of one law, and of one id: by their directories
    hop = table.row(0, named=True)
    assert all(name.endswith(f": {hop['running_kwh']:.2f} kWh, {hop['run_s']:.0f} s") for name in energies)
    assert table["run"].n_unique() == 3
    other = replace(read, line=replace(read.line, id="elsewhere"))
    with pytest.raises(InputError, match="a run of the line"):
        chosen_run(read, Choice(train, beside=(other,)))
    with pytest.raises(InputError, match="--with"):
        write_plot(read, kind_of("margins"), Choice(beside=(read,)), Format.CSV, Path("never.csv"))


@pytest.mark.parametrize(
    ("late_s", "told"), [(90.0, {"mean ± σ", "95th percentile", "worst"}), (None, set())]
)
def test_punctuality_says_what_its_marks_are_where_no_train_has_arrived(
    late_s: float | None, told: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Departures alone, at a station whose name would lie over its neighbours'; without any, that none is there."""
    names = ("sigma_s", "mean_s", "p95_s", "worst_s")
    figures = {name: None if late_s is None else (k + 1) * late_s for k, name in enumerate(names)}
    row = {
        "station": "A",
        "what": "departure",
        "on_time_share": 0.25,
        "worst_train": "T1",
        "whole_minutes": False,
    }
    monkeypatch.setattr(stations, "punctuality_table", lambda _run: pl.DataFrame([row | figures]))
    run: Any = SimpleNamespace(
        stations=[SimpleNamespace(id="A")], name=lambda _id: "A" * 80, choice=SimpleNamespace(language="en")
    )
    figure = stations.draw_punctuality(run)
    assert figure is not None
    share, late = figure.axes
    legend = late.get_legend()
    assert {text.get_text() for text in (legend.get_texts() if legend else ())} == told
    assert [bar.get_height() for bar in share.patches] == [25.0]  # percent
    at = {mark.get_label(): mark.get_ydata()[0] for mark in late.lines}
    at |= {bars.get_label(): bars.lines[0].get_ydata()[0] for bars in late.containers}
    assert [at[name] for name in sorted(told)] == [270.0, 180.0, 360.0][: len(told)]
    assert [text.get_text() for text in late.texts if text.get_text() == stations.NOBODY] == (
        [] if told else [stations.NOBODY]
    )
    assert [text.get_text() for text in share.get_legend().get_texts()] == ["departure"]
    assert late.get_xticklabels()[0].get_text() == "A" * 13 + "."


@pytest.mark.parametrize(
    "kind", ["track-occupation", "section-occupancy", "train-graph", "delays", "punctuality"]
)
def test_a_set_that_never_came_is_in_the_pictures_of_the_plan(read: RunRead, kind: str) -> None:
    times = [pl.lit(None, pl.Float64).alias(name) for name in ("arrival_s", "departure_s")]
    tables = replace(
        read.tables,
        stops=read.tables.stops.with_columns(times),
        trajectory=read.tables.trajectory.clear(),
        blocks=read.tables.blocks.clear(),
    )
    run = chosen_run(replace(read, tables=tables), Choice())
    with drawing():
        figure = figure_of(run, kind_of(kind))
    assert not {"nan", "inf", "None"} & {text.get_text() for text in figure.findobj(Text)}  # type: ignore[union-attr]
