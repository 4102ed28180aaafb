"""Import a track layout from railML 2.4 or 3.2 (infrastructure).

Both versions of one layout give the same tracks, lengths, ordinary points and stations: `railml2` and `railml3` read
what each writes in its own way into one draft, from which `railml_draft` makes the layout.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

from exchange.layout import ForeignLayout
from exchange.railml2 import draft_of_2
from exchange.railml3 import draft_of_3
from exchange.railml_draft import layout_of
from exchange.xml_input import local_name, namespace_of, read_xml
from network.errors import InputError

NAMESPACES: Final = {
    "2.4": "https://www.railml.org/schemas/2018",
    "3.2": "https://www.railml.org/schemas/3.2",
}
_ROOT_NAMES: Final = ("railml", "railML")


def read_railml(path: Path) -> ForeignLayout:
    """The layout of a railML file. Raises InputError for another form, another version, or a file with no tracks."""
    file = str(path)
    root = read_xml(path)
    if local_name(root) not in _ROOT_NAMES:
        raise InputError(
            file, "", None, f"railML 2.4 or 3.2, but the outermost element is {local_name(root)}"
        )
    version = root.get("version", "")
    if version not in NAMESPACES:
        raise InputError(file, "version", version, "railML of version 2.4 or 3.2")
    if namespace_of(root) != NAMESPACES[version]:
        expected = f"{NAMESPACES[version]}, the namespace of railML {version}"
        raise InputError(file, "xmlns", namespace_of(root), expected)
    draft = draft_of_2(file, root) if version == "2.4" else draft_of_3(file, root)
    if not draft.pieces:
        expected = "railML with an infrastructure that has tracks: net elements with a length, of the microscopic level"
        raise InputError(file, "", None, expected)
    return layout_of(draft, f"railML {version}, {path.name}")
