"""The settings of the driving laws: one table of a scenario a law, `[law.NAME]`, made from the table of laws."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Final

from pydantic import Field, create_model

from network.files.kinds import about
from network.files.toml_input import Record
from onboard.driving.laws.table import LAWS, LawsRow
from vehicle.record import put_settings

WITH_SETTINGS: Final[Mapping[str, type[Record]]] = {
    law.name: law.settings for law in LAWS if law.settings is not None
}


class _LawTables(Record):
    """`[law]`: settings of the driving laws, a table each; they hold for every stock that is driven so."""


def _with_fields() -> type[_LawTables]:
    """The class of `[law]`, with a field for every law that has settings."""
    fields: dict[str, Any] = {
        name: (
            Annotated[settings, about((settings.__doc__ or name).strip())],
            Field(default_factory=settings),
        )
        for name, settings in WITH_SETTINGS.items()
    }
    return create_model("LawTables", __base__=_LawTables, __doc__=_LawTables.__doc__, **fields)


if TYPE_CHECKING:

    class LawTables(_LawTables):
        """What type checkers see of it."""

else:
    LawTables = _with_fields()


def fit_law(
    laws: LawsRow,
    name: str,
    tables: Record | None = None,
    drawn: Callable[[str, str], float] = lambda _law, _field: 0.0,
) -> None:
    """Choose the law of one train, and put the settings of all laws into their rows.

    `drawn` gives the figure of a law's field that is drawn for each stock; the mean if left out. ValueError for a law
    that there is not.
    """
    given = LawTables() if tables is None else tables
    choose_law(laws, name)
    for law in LAWS:
        own = getattr(laws, law.name)
        if law.settings is not None:
            put_settings(own.settings, getattr(given, law.name))
        for field in law.drawn:
            setattr(own, field, drawn(law.name, field))


def choose_law(laws: LawsRow, name: str) -> None:
    """From now on this law drives. ValueError for one that there is not."""
    laws.number = [law.name for law in LAWS].index(name)
    laws.stops = int(LAWS[laws.number].stops)
