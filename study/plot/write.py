"""One kind of plot of a run as PNG, SVG or CSV: the same run gives the same file."""

from __future__ import annotations

from pathlib import Path

import polars as pl
from matplotlib.figure import Figure

from network.errors import InputError
from network.files.json_input import write_bytes_aside
from network.files.toml_input import one_of
from study.measures.wait_text import at_time
from study.plot.choice import Choice, ChosenRun, chosen_run
from study.plot.kinds import PlotKind, PlotOption
from study.plot.words import translate
from study.record.read_back import RunRead
from study.report.drawn import DrawnFigure, Format
from study.report.style import drawing


def format_of(name: str | None, out: Path | None) -> Format:
    """The format of that name, else of the file's ending, else PNG. InputError for another."""
    key, wanted = "--format", name
    if wanted is None and out is not None and out.suffix:
        key, wanted = "--out", out.suffix[1:].lower()
    try:
        return Format("png" if wanted is None else wanted)
    except ValueError:
        raise InputError("command line", key, wanted, one_of([f.value for f in Format])) from None


def write_plot(read: RunRead, kind: PlotKind, choice: Choice, form: Format, out: Path) -> None:
    """Write a plot; nothing stays if that fails.

    InputError for a choice that the kind does not take or lacks, for one that shows nothing, for a path that cannot
    be written.
    """
    run = _checked_run(read, kind, choice, form)
    data = csv_of(kind.table(run)) if form is Format.CSV else _picture(run, kind).in_form(form)
    write_bytes_aside(out, data, data[:3])


def csv_of(table: pl.DataFrame) -> bytes:
    """The table in UTF-8 with a mark at its beginning, which spreadsheets need to read Japanese."""
    return b"\xef\xbb\xbf" + table.write_csv().encode("utf-8")


def default_name(kind: PlotKind, choice: Choice, form: Format) -> str:
    """The file's name where nobody gives one: the kind, and the train or station chosen."""
    return "-".join(filter(None, (kind.name, choice.train, choice.station))) + f".{form.value}"


def _chosen(choice: Choice) -> dict[PlotOption, str | None]:
    time_s = choice.to_s if choice.from_s is None else choice.from_s
    return {
        PlotOption.TRAIN: choice.train,
        PlotOption.STATION: choice.station,
        PlotOption.TIME: None if time_s is None else at_time(time_s),
        PlotOption.RUNS: ", ".join(read.name for read in choice.beside) or None,
    }


def _check_taken(kind: PlotKind, choice: Choice) -> None:
    for option, value in _chosen(choice).items():
        if value is not None and option not in kind.takes:
            takes = ", ".join(sorted(o.value for o in kind.takes)) or "no choice"
            raise InputError("command line", option.value, value, f"what {kind.name} takes: {takes}")


def _check_needed(run: ChosenRun, kind: PlotKind, choice: Choice, form: Format) -> None:
    for option, value in _chosen(choice).items():
        if value is None and option in kind.needs and form is not Format.CSV:
            known = list(run.trains) if option is PlotOption.TRAIN else list(run.line.stations)
            raise InputError("command line", option.value, None, f"{one_of(known)}: a picture is of one")


def picture_of(read: RunRead, kind: PlotKind, choice: Choice) -> DrawnFigure:
    """The picture of a kind. InputError for a choice that it does not take or lacks, or that shows nothing."""
    return _picture(_checked_run(read, kind, choice, Format.PNG), kind)


def _picture(run: ChosenRun, kind: PlotKind) -> DrawnFigure:
    with drawing():
        return DrawnFigure(figure_of(run, kind), kind.name)


def _checked_run(read: RunRead, kind: PlotKind, choice: Choice, form: Format) -> ChosenRun:
    _check_taken(kind, choice)
    run = chosen_run(read, choice)
    _check_needed(run, kind, run.choice, form)
    return run


def figure_of(run: ChosenRun, kind: PlotKind) -> Figure:
    """The picture, with its title, in the language chosen; call within `drawing()`. InputError where there is none."""
    figure = kind.draw(run)
    if figure is None:
        raise InputError("command line", "KIND", kind.name, "a kind for which the run has data")
    figure.suptitle(title_of(run, kind), x=0.008, ha="left", fontsize=9.5)
    translate(figure, run.choice.language)
    return figure


def title_of(run: ChosenRun, kind: PlotKind) -> str:
    """What stands above a picture: the kind, of what of the run, and the run's name."""
    choice = run.choice
    parts = [kind.title.in_(choice.language)]
    if choice.train is not None:
        parts.append(choice.train)
    if choice.station is not None:
        parts.append(run.name(choice.station))
    if choice.from_s is not None or choice.to_s is not None:
        parts.append("–".join(at_time(time_s) for time_s in run.window_s))
    return " · ".join([*parts, run.read.name])
