"""What grows unless it is counted: names taken twice, lines, lists of fields that are restated, figures of a slice.

`documents/ceilings.toml` has what there still is of each. It may only shrink: a name or figure in it that is no
longer so is an error too, so that what was mended stays mended.
"""

from __future__ import annotations

import ast
import json
import tomllib
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Final

from documents.structure_rule import LAYERS, PRODUCT, TESTS, StructureRule

CEILINGS: Final = Path(__file__).with_name("ceilings.toml")
KEPT: Final = "documents/reproductions.json"
UNSAID: Final = "nothing says that it comes of all runs"
FIELDS_MIN: Final = 6  # as many names in a row, in one order, make a list of fields
ROOM_SHARE_MAX: Final = 0.15
# Of what it bounds: room for what one recipe adds. A ceiling further above that is to be lowered.
BELOW_CEILING: Final = 0.05
ABOVE_SIMULATION: Final = (*LAYERS[: LAYERS.index("simulation")], "exchange")
DIVIDED: Final = "study"  # its folders are rooms of their own


@dataclass(frozen=True, slots=True)
class Ceilings:
    """What may still be. `pairs`: of restated lists of fields; `slices`: reproductions kept of a short slice."""

    class_names: frozenset[str]
    product_lines: int
    test_lines: int
    pairs: int
    slices: frozenset[str] = frozenset()


def ceilings(file: Path = CEILINGS) -> Ceilings:
    """What is committed."""
    said = tomllib.loads(file.read_text("utf-8"))
    return Ceilings(
        frozenset(said["class_names"]),
        said["product_lines"],
        said["test_lines"],
        said["pairs"],
        frozenset(said["slices"]),
    )


def trees(root: Path) -> dict[Path, ast.Module]:
    """Every Python file of the product, by its path below the root, parsed."""
    files = [file for package in PRODUCT for file in sorted((root / package).rglob("*.py"))]
    return {file.relative_to(root): ast.parse(file.read_text("utf-8")) for file in files}


def class_names_rule(product: Mapping[Path, ast.Module], excepted: frozenset[str]) -> StructureRule:
    """A reader of another file knows a class by its name alone."""
    places: dict[str, list[str]] = defaultdict(list)
    for file, tree in product.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                places[node.name].append(f"{file}:{node.lineno}")
    twice = {name: found for name, found in places.items() if len(found) > 1}
    advice = "one class where both mean the same, else the field's term with what tells it apart"
    new = [f"{name} in {', '.join(twice[name])}: {advice}" for name in sorted(twice.keys() - excepted)]
    gone = [_take_out(name, "class_names") for name in sorted(excepted - twice.keys())]
    found = f"{len(places)} names, {len(twice)} of them still taken more than once"
    return StructureRule("no class name twice", found, (*new, *gone))


def slices(kept: Mapping[str, Mapping[str, object]]) -> dict[str, str]:
    """What was left out of kept reproductions that do not come of all their runs, by name."""
    said = {name: str(one.get("slice", UNSAID)) for name, one in kept.items()}
    return {name: text for name, text in said.items() if text}


def slices_rule(root: Path, excepted: frozenset[str]) -> StructureRule:
    """A slice's figures look like those of all runs."""
    file = root / KEPT
    kept: dict[str, dict[str, object]] = json.loads(file.read_text("utf-8")) if file.exists() else {}
    short = slices(kept)
    new = [
        f"{name}: {short[name]}; `make reproductions NAMES={name}`"
        for name in sorted(short.keys() - excepted)
    ]
    gone = [_take_out(name, "slices") for name in sorted(excepted - short.keys())]
    found = f"{len(kept)}, {len(short)} of them still of a short slice"
    return StructureRule("no figure of a slice among the reproductions", found, (*new, *gone))


def sizes_rule(root: Path, ceiling: Ceilings) -> StructureRule:
    """Lines fall by restating removed; a room that has grown beyond its share wants to be two, or less."""
    lines = {
        file.relative_to(root): _lines(file) for package in PRODUCT for file in (root / package).rglob("*.py")
    }
    product, tests = sum(lines.values()), sum(_lines(file) for file in (root / TESTS).rglob("*.py"))
    rooms: dict[str, int] = defaultdict(int)
    for file, count in lines.items():
        divided = file.parts[0] == DIVIDED and len(file.parts) > 2
        rooms["/".join(file.parts[: 2 if divided else 1])] += count
    broken = [
        f"{room} has {count} lines of {product}: divide it by what it does, or take out what others have too"
        for room, count in rooms.items()
        if room.split("/")[0] in ABOVE_SIMULATION and count > ROOM_SHARE_MAX * product
    ]
    broken += _against("lines of the product", product, ceiling.product_lines, "product_lines")
    broken += _against("lines of the tests", tests, ceiling.test_lines, "test_lines")
    text = f"no room above the simulation over {ROOM_SHARE_MAX:.0%} of the product, and no more lines than there were"
    return StructureRule(text, f"product {product}, tests {tests}", tuple(broken))


def field_lists_rule(product: Mapping[Path, ast.Module], pairs_max: int) -> StructureRule:
    """Every fact once: a list of field names in a second place waits for its edit."""
    pairs = list(restated(product))
    broken = _against("pairs of restated lists of fields", len(pairs), pairs_max, "pairs")
    if len(pairs) > pairs_max:
        broken += [f"{one} and {other}: hand the record on, or make one of the other" for one, other in pairs]
    found = f"{len(pairs)} pairs of classes or calls that share {FIELDS_MIN} names in a row"
    return StructureRule("no list of fields restated", found, tuple(broken))


def restated(product: Mapping[Path, ast.Module]) -> Iterator[tuple[str, str]]:
    """Pairs of places, classes with their fields or calls by keyword, that share names in a row.

    A class and a call that makes one of it are no pair, nor are two calls that make one class: each gives other values
    to the one list, and by position they would give them without names. Two classes are always a pair, and so is a
    class with a call that makes another, though both derive from one.
    """
    bases = {
        node.name: [_name(base) for base in node.bases]
        for tree in product.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
    }
    lists: list[_FieldList] = []
    for file, tree in product.items():
        for node in ast.walk(tree):
            names = _fields(node)
            runs = frozenset(tuple(names[i : i + FIELDS_MIN]) for i in range(len(names) - FIELDS_MIN + 1))
            place = f"{file}:{node.lineno}" if isinstance(node, ast.ClassDef | ast.Call) else ""
            if isinstance(node, ast.ClassDef) and runs:
                lists.append(_FieldList(place, runs, node.name))
            elif isinstance(node, ast.Call) and runs:
                line = tuple(_with_bases(_name(node.func), bases))
                lists.append(_FieldList(place, runs, None, line))
    for one, other in combinations(lists, 2):
        if one.runs & other.runs and not one.makes(other):
            yield one.place, other.place


@dataclass(frozen=True, slots=True)
class _FieldList:
    """Field names where they stand: in the class `defines`, or in a call that makes the first class of `made`, which
    derives from the others.
    """

    place: str
    runs: frozenset[tuple[str, ...]]
    defines: str | None
    made: tuple[str, ...] = ()

    def makes(self, other: _FieldList) -> bool:
        """Whether one is a class and the other a call that makes it, or both are calls that make one class."""
        return (
            self.defines in other.made or other.defines in self.made or self.made[:1] == other.made[:1] != ()
        )


def rules(root: Path, ceiling: Ceilings) -> tuple[StructureRule, ...]:
    """All of them."""
    product = trees(root)
    return (
        class_names_rule(product, ceiling.class_names),
        sizes_rule(root, ceiling),
        slices_rule(root, ceiling.slices),
        field_lists_rule(product, ceiling.pairs),
    )


def _fields(node: ast.AST) -> list[str]:
    if isinstance(node, ast.ClassDef):
        targets = [item.target for item in node.body if isinstance(item, ast.AnnAssign)]
        return [target.id for target in targets if isinstance(target, ast.Name)]
    if isinstance(node, ast.Call):
        return [keyword.arg for keyword in node.keywords if keyword.arg is not None]
    return []


def _name(node: ast.expr) -> str:
    """The last part of a dotted name, without what stands in brackets behind it."""
    if isinstance(node, ast.Subscript):
        return _name(node.value)
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""


def _with_bases(name: str, bases: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """A class of the product and all that it derives from; nothing of what is no class."""
    if name in bases:
        yield name
        for base in bases[name]:
            yield from _with_bases(base, bases)


def _lines(file: Path) -> int:
    return len(file.read_text("utf-8").splitlines())


def _against(what: str, count: int, most: int, key: str) -> list[str]:
    if count > most:
        return [f"{count} {what}, {most} were there: find what says the same and keep one of them"]
    if count < (1.0 - BELOW_CEILING) * most:
        return [f"{count} {what}: lower `{key}` in {CEILINGS.name} from {most} to that"]
    return []


def _take_out(what: str, key: str) -> str:
    return f"{what}: mended, take it out of `{key}` in {CEILINGS.name}"
