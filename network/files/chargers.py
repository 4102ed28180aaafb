"""`[[chargers]]` of a line file, checked against its stations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from network.errors import InputError
from network.files.line_schema import ChargerTable
from network.files.toml_input import one_of
from network.model import Charger, Station


def chargers_of(
    file: str, tables: Sequence[ChargerTable], stations: Mapping[str, Station]
) -> dict[str, Charger]:
    """Chargers by station id. InputError for a station or track that is not there, or a second charger at a station."""
    chargers: dict[str, Charger] = {}
    for i, table in enumerate(tables):
        key = f"chargers[{i}]"
        if table.station not in stations:
            raise InputError(
                file, f"{key}.station", table.station, f"a station id, {one_of(stations, table.station)}"
            )
        if table.station in chargers:
            raise InputError(
                file, f"{key}.station", table.station, "one charger a station: give it more tracks"
            )
        known = [track.name for track in stations[table.station].tracks]
        for j, track in enumerate(table.tracks or ()):
            if track not in known:
                expected = f"a track of {table.station}, {one_of(known, track)}"
                raise InputError(file, f"{key}.tracks[{j}]", track, expected)
        tracks = tuple(known if table.tracks is None else table.tracks)
        power_w = table.power_kw * 1e3
        if table.current_max_a is not None:
            power_w = min(power_w, table.current_max_a * table.voltage_v)
        chargers[table.station] = Charger(table.station, tracks, power_w, table.connect_s, table.disconnect_s)
    return chargers


def without_track(tables: Sequence[ChargerTable], station_id: str, track: str) -> list[ChargerTable]:
    """Chargers without a track that has been taken out; one that served that alone is gone."""
    kept: list[ChargerTable] = []
    for table in tables:
        if table.station != station_id or table.tracks is None:
            kept.append(table)
            continue
        left = [name for name in table.tracks if name != track]
        if left:
            kept.append(table.model_copy(update={"tracks": left}))
    return kept
