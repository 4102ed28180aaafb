"""The scenario file's tables: those of a run as they are, and what names the other files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import TYPE_CHECKING, Annotated, Any, Final, get_type_hints

from pydantic import Field, create_model

from network.files.edits import FilePatch
from network.files.kinds import TABLES_MAX, TEXTS_MAX, about
from network.files.names import Identifier, Prose, Title
from network.files.quantities import Seed
from network.files.toml_input import Record
from network.patching.patch import LinePatch
from network.patching.timetable_patch import TimetablePatch
from scenario.belief import BeliefTable
from scenario.script_file import ActTable, ExpectTable, FaultTable
from simulation.settings import Load, Tables


class TrainsTable(Load):
    """`[trains]`: which train file each stock runs as, and how full trains are."""

    default: Annotated[
        str, about("train file of every stock that is not named, shipped or beside the scenario")
    ]
    stock: Annotated[dict[str, str], about("train file by stock id")] = Field(default_factory=dict)


class SettingsPatch(Record):
    """A patch of one of the scenario's own tables (`[patch.air]`): on what the extended scenarios say."""

    values: Annotated[dict[str, Any], about("values set, by key path")] = Field(
        default_factory=dict, alias="set"
    )
    times: Annotated[dict[str, float], about("numbers multiplied by a factor, by key path")] = Field(
        default_factory=dict
    )


class ListPatch(SettingsPatch):
    """A patch of one of the scenario's own lists (`[patch.fault]`)."""

    remove: Annotated[list[str | int], about("entries taken out, by index")] = Field(default_factory=list)
    add: Annotated[list[dict[str, Any]], about("entries added")] = Field(default_factory=list)


class _OtherFiles(Record):
    line: Annotated[LinePatch | None, about("on the line file")] = None
    timetable: Annotated[TimetablePatch | None, about("on the timetable file")] = None
    train: Annotated[dict[str, FilePatch], about("on train files, by their name")] = Field(
        default_factory=dict
    )


class _Named(Record):
    extends: Annotated[str | None, about("scenario whose tables hold wherever this one says nothing")] = None
    id: Annotated[Identifier, about("name of the run and of its directory")]
    name: Annotated[Title, about("display name")]
    line: Annotated[str, about("line file, shipped or beside the scenario")]
    timetable: Annotated[str, about("timetable file, shipped or beside the scenario")]
    seed: Annotated[Seed, about("seed of all random draws; --seed overrides it", "assumed: any will do")] = 1
    assumed: Annotated[
        list[Prose],
        Field(max_length=TEXTS_MAX),
        about("what has no published source, in sentences for the report"),
    ] = Field(default_factory=list)
    trains: TrainsTable


_KINDS: Final = get_type_hints(Tables, include_extras=True)
TABLES: Final[Mapping[str, Any]] = {  # by name: kind and default of each field of `Tables`
    each.name: (
        _KINDS[each.name],
        each.default if each.default_factory is MISSING else Field(default_factory=each.default_factory),
    )
    for each in fields(Tables)
}

if TYPE_CHECKING:  # the tables' types are those of `Tables`, which `ScenarioFile.tables` gives

    class _PatchedTables(_OtherFiles):
        pass

    class _WithTables(_Named):
        pass

else:
    _PatchedTables = create_model(
        "_PatchedTables",
        __base__=_OtherFiles,
        **{
            name: (Annotated[SettingsPatch | None, about(f"on [{name}]")], None)
            for name in (*TABLES, "trains")
        },
    )
    _WithTables = create_model("_WithTables", __base__=_Named, **TABLES)


class PatchTable(_PatchedTables):
    """`[patch]`: a what-if on every file that the scenario names, and on what it takes over from others.

    Patches of scenarios that extend one another are carried out one after the other, the extended one's first.
    """

    fault: Annotated[ListPatch | None, about("on [[fault]]")] = None
    act: Annotated[ListPatch | None, about("on [[act]]")] = None
    expect: Annotated[ListPatch | None, about("on [[expect]]")] = None


class ScenarioFile(_WithTables):
    """A scenario: line, timetable, trains and everything that may differ from run to run.

    A drill is a scenario with faults, acts and expectations.
    """

    belief: Annotated[
        BeliefTable | None, about("what units assume of line and trains where that differs from the truth")
    ] = None
    patch: Annotated[PatchTable, about("changes to the files named: a what-if")] = Field(
        default_factory=PatchTable
    )
    fault: Annotated[list[FaultTable], Field(max_length=TABLES_MAX), about("what fails, and when")] = Field(
        default_factory=list
    )
    act: Annotated[list[ActTable], Field(max_length=TABLES_MAX), about("what people do about it")] = Field(
        default_factory=list
    )
    expect: Annotated[
        list[ExpectTable], Field(max_length=TABLES_MAX), about("what must happen, for a drill to pass")
    ] = Field(default_factory=list)

    @property
    def tables(self) -> Tables:
        """The tables that a run reads as they are."""
        return Tables(**{name: getattr(self, name) for name in TABLES})
