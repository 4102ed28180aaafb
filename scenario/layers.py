"""A scenario and the files that it extends, in layers: each file overrides the one it extends, and has its own patches.

A key of the upper file replaces that of the lower one, a list too; tables are merged key by key. `[patch]`
changes what is there instead: of the scenario's own tables here, of the other files where those are read.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from pydantic import BaseModel, ValidationError

from network.errors import InputError
from network.files.edits import Change, Data, Patched, PatchInFile, differences
from network.files.text_input import existing_file
from network.files.toml_input import key_path, parse_table, read_text, validate
from network.raw import is_table
from scenario.scenario_file import ListPatch, PatchTable, ScenarioFile, SettingsPatch

KEYWORDS: Final = Path("keywords")  # of tables given to `load_scenario`: their file, in errors and as a place
# Files of other kinds, by a key that no scenario has, and what makes a scenario of one.
_OTHERS: Final = {
    "alignments": "line file: `branchline new timetable TIMES.toml --line {0} --scenario DAY.toml` makes one",
    "diagrams": 'timetable: a scenario has `timetable = "{0}"` and its line',
    "provenance": 'train file: a scenario has `[trains] default = "{0}"`, a line and a timetable',
    "scenario": "sweep: `branchline sweep {0}` runs it",
    "stations": "list of stations: `branchline new line {0} LINE.toml --scenario DAY.toml` makes one",
}
_FILES: Final = ("line", "timetable", "train")
# Names, prose and the script are what a scenario is, not what it changes.
_NO_CHANGE: Final = frozenset({"id", "name", "assumed", "fault", "act", "expect", "patch", "extends"})


@dataclass(frozen=True, slots=True)
class ScenarioLayers:
    """A scenario with all that it extends: its tables, and patches of other files in order.

    `said_in`: by key path, the file that has the value; what it names may lie beside it.
    """

    data: Data
    changes: tuple[Change, ...] = ()
    files: Mapping[str, tuple[PatchInFile, ...]] = field(default_factory=dict[str, tuple[PatchInFile, ...]])
    trains: Mapping[str, tuple[PatchInFile, ...]] = field(default_factory=dict[str, tuple[PatchInFile, ...]])
    # Key path: file and key of its patch.
    written: Mapping[str, tuple[str, str]] = field(default_factory=dict[str, tuple[str, str]])
    said_in: Mapping[str, Path] = field(default_factory=dict[str, Path])

    def validated(self, path: Path) -> ScenarioFile:
        """The scenario's tables, checked."""
        return validate(self.data, str(path), ScenarioFile)

    @contextmanager
    def naming_the_patch(self, path: Path) -> Generator[None]:
        """An error in a key of the scenario names the patch, keyword or file that has written it."""
        try:
            yield
        except InputError as error:
            if error.file != str(path):
                raise
            for key, (file, asked) in self.written.items():
                of_key = error.key.startswith((f"{key}.", f"{key}[")) or f"{key}.".startswith(f"{error.key}.")
                if of_key:
                    raise InputError(
                        file, asked + error.key[len(key) :], error.value, error.expected
                    ) from error
            own = self.files_of(error.key)
            raise InputError(
                str(own[0] if len(own) == 1 else path), error.key, error.value, error.expected
            ) from error

    def files_of(self, key: str) -> tuple[Path, ...]:
        """The file that has the value of a key path, or those that have what lies below it; none of a default."""
        said = self.said_in.items()
        found = [file for own, file in said if _within(key, own)] or [
            f for own, f in said if _within(own, key)
        ]
        return tuple(dict.fromkeys(found))


def _within(key: str, of: str) -> bool:
    """Whether a key path is another one, or lies below it."""
    return f"{key}.".startswith((f"{of}.", f"{of}["))


def layers_of(
    path: Path, find: Callable[[Path, str], Path], keywords: Mapping[str, object] | None = None
) -> ScenarioLayers:
    """Read a scenario and those it extends; `find` gives the file of a name that a file extends.

    `keywords` are tables, with `patch` among them, which override as those of a file in the working directory would.
    """
    layers = _layers(path, find, ())
    if keywords:
        if "extends" in keywords:
            raise InputError(
                str(KEYWORDS), "extends", keywords["extends"], "no such keyword: the scenario is named"
            )
        layers.append((KEYWORDS, deepcopy(dict(keywords))))
    low, below = layers[0]
    files: dict[str, tuple[PatchInFile, ...]] = {}
    trains: dict[str, tuple[PatchInFile, ...]] = {}
    written: dict[str, tuple[str, str]] = {}
    data: Data = {}
    said_in: dict[str, Path] = {}
    for file, table in layers:
        patch = _patch_of(file, table.pop("patch", {}))
        data = merged_tables(data, table)
        said_in |= dict.fromkeys(_paths(table), file)
        if file is KEYWORDS:
            written |= {key: (str(KEYWORDS), key) for key in _paths(table)}
        for name, words in patch.items():
            asked = PatchInFile(words, str(file), f"patch.{name}")
            if name in ("line", "timetable"):
                files[name] = (*files.get(name, ()), asked)
            elif name == "train":
                for train, own in words.items():
                    trains[train] = (
                        *trains.get(train, ()),
                        PatchInFile(own, str(file), f"patch.train.{train}"),
                    )
            else:
                _patch_table(data, name, asked, written)
    before, after = _whole(below), _whole(data)
    changes = tuple(differences(low.name, before, after))
    return ScenarioLayers(data, changes, files, trains, written, said_in)


def _paths(table: Mapping[str, Any], above: str = "") -> Iterator[str]:
    """Key paths of all values, as errors have them."""
    for key, value in table.items():
        if is_table(value) and value:
            yield from _paths(value, f"{above}{key}.")
        else:
            yield f"{above}{key}"


def merged_tables(below: Mapping[str, Any], above: Mapping[str, Any]) -> Data:
    """The tables of one over those of the other, key by key."""
    merged = dict(below)
    for key, value in above.items():
        known = merged.get(key)
        merged[key] = merged_tables(known, value) if is_table(known) and is_table(value) else value
    return merged


def _layers(
    path: Path, find: Callable[[Path, str], Path], above: tuple[Path, ...]
) -> list[tuple[Path, Data]]:
    """Files and their tables, the lowest first."""
    if path in above:
        raise InputError(str(above[-1]), "extends", path.stem, "a scenario that does not extend itself")
    data = parse_table(read_text(path), str(path))
    for key, what in _OTHERS.items():
        if key in data:
            raise InputError(str(path), "", None, f"a scenario; this is a {what.format(path)}")
    base = data.pop("extends", None)
    if base is None:
        return [(path, data)]
    if not isinstance(base, str):
        raise InputError(str(path), "extends", base, "the name of a scenario")
    beside = path.parent / f"{base.removesuffix('.toml')}.toml"
    below = beside if existing_file(beside) else find(path, base)
    return [*_layers(below, find, (*above, path)), (path, data)]


def _patch_of(file: Path, patch: object) -> dict[str, Any]:
    """The patch of one file, in its own words: which targets there are is checked here."""
    if not is_table(patch):
        raise InputError(str(file), "patch", patch, "tables such as [patch.line]")
    others = {name: words for name, words in patch.items() if name not in _FILES}
    try:
        validate(others, str(file), PatchTable)
        for name in _FILES:
            if not is_table(patch.get(name, {})):
                raise InputError(str(file), name, patch[name], "a table")
    except InputError as error:
        raise InputError(str(file), f"patch.{error.key}", error.value, error.expected) from error
    return patch


def _patch_table(data: Data, name: str, asked: PatchInFile, written: dict[str, tuple[str, str]]) -> None:
    """Patch one of the scenario's own tables or lists, in place of what the layers have so far."""
    listed = PatchTable.model_fields[name].annotation == ListPatch | None
    words = validate(asked.words, asked.file, ListPatch if listed else SettingsPatch)
    own: Any = deepcopy(data.get(name, [] if listed else {}))
    known = _defaults(name)
    for path in words.times:
        if not listed and path in known:
            own.setdefault(path, known[path])
    patched = Patched(asked.file, asked.key, "scenario", {name: own})
    if isinstance(words, ListPatch):
        # By falling index, so that each means what the file that is patched calls so.
        for index in sorted((str(i) for i in words.remove), key=_by_index, reverse=True):
            patched.remove(name, index, f"{asked.key}.remove")
    for path, value in words.values.items():
        key = f'{asked.key}.set."{path}"'
        patched.set_value(f"{name}.{path}", value, key)
        written[_as_told(f"{name}.{path}")] = (asked.file, key)
    for path, factor in words.times.items():
        key = f'{asked.key}.times."{path}"'
        patched.multiply(f"{name}.{path}", factor, key)
        written[_as_told(f"{name}.{path}")] = (asked.file, key)
    if isinstance(words, ListPatch):
        for i, row in enumerate(words.add):
            written[f"{name}[{len(own)}]"] = (asked.file, f"{asked.key}.add[{i}]")
            own.append(deepcopy(row))
    data[name] = own


def _as_told(path: str) -> str:
    """A key path as errors have it, with indices in brackets."""
    return key_path(int(step) if step.isdecimal() else step for step in path.split("."))


def _by_index(text: str) -> tuple[int, str]:
    return (int(text) if text.isdecimal() else -1, text)


def _defaults(name: str) -> dict[str, Any]:
    """The defaults of a table, by key; of its plain values, not of tables in it."""
    kind = ScenarioFile.model_fields[name].annotation
    if not isinstance(kind, type) or not issubclass(kind, BaseModel):
        return {}
    fields = kind.model_fields.items()
    return {key: f.default for key, f in fields if not f.is_required() and f.default_factory is None}


def _whole(data: Data) -> Data:
    """The tables with all defaults, without what is no setting; as they are where they are not valid alone."""
    try:
        whole = ScenarioFile.model_validate(data).model_dump(mode="json", by_alias=True)
    except ValidationError:
        whole = data
    return {key: value for key, value in whole.items() if key not in _NO_CHANGE}
