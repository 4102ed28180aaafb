"""Stations as people call them: by id, by name or by Japanese name, in capitals or not."""

from __future__ import annotations

from network.errors import COMMAND_LINE, InputError
from network.files.toml_input import one_of
from network.model import Line


def station_id_of(line: Line, said: str) -> str:
    """The id of the station that is called so. InputError where there is none, or more than one by that name."""
    if said in line.stations:
        return said
    word = said.casefold()
    found = [s.id for s in line.stations.values() if word in map(str.casefold, (s.id, s.name, s.name_ja))]
    if len(found) != 1:
        raise InputError(COMMAND_LINE, "--station", said, one_of(found or line.stations, said))
    return found[0]
