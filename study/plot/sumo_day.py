"""A scenario for plain SUMO, to be looked at in sumo-gui and netedit: net, trains, scenery and configuration.

Trains are SUMO's own there: no units, no sections, no radio. Their routes and marks are those that the run draws up.
Roads are those of the run with its vehicles; no crossing closes, and trains and vehicles do not see one another.
"""

from __future__ import annotations

import gzip
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from host.scratch import scratch
from network.errors import COMMAND_LINE, InputError
from network.files.crossing_road import roads_of
from network.model import Direction, Line
from network.timetable import Diagram
from onboard.mission import NoWay, Target
from simulation.carriers.road_demand import road_vehicles
from simulation.carriers.road_of_run import roads_at
from simulation.setup import Setup
from simulation.world.roster import Duty, drawn_up
from study.record.as_run import trains_as_run
from study.record.read_back import RunRead
from sumo_cfg.build import net_for
from sumo_cfg.road_traffic import road_routes_xml
from sumo_cfg.scenery import scenery_xml, stop_id
from sumo_cfg.traffic import SumoVehicle, VehicleStop, VehicleType, config_xml, routes_xml
from sumo_cfg.writer import edge_id
from vehicle.train_file import TrainType

BEFORE_S: Final = 60.0  # a set that is stabled appears this long before its first departure
AFTER_S: Final = 3600.0  # the configuration's end, after the last planned time


@dataclass(frozen=True, slots=True)
class SumoDay:
    """What was written: files by what they are, and how many vehicles, trains and stops."""

    files: tuple[Path, ...]
    config: Path
    vehicles: int
    trains: int
    stops: int


def setup_as_run(run: RunRead) -> Setup:
    """The day of a finished run, its trains with the times and tracks that they had; those that never left are out."""
    trains = {train.number: train for train in trains_as_run(run.timetable, run.tables.stops)}
    kept = (
        Diagram(diagram.stock_id, tuple(n for n in diagram.train_numbers if n in trains))
        for diagram in run.timetable.diagrams
    )
    timetable = replace(
        run.timetable, trains=trains, diagrams=tuple(diagram for diagram in kept if diagram.train_numbers)
    )
    return Setup(
        run.name,
        run.line,
        timetable,
        run.trains,
        seed=run.settings.seed,
        operation=run.settings.tables.operation,
        roads=roads_of(run.inputs.line, str(run.directory)),
        day=run.settings.tables.tuning.days,
    )


def export_sumo(name: str, setup: Setup, out: Path) -> SumoDay:
    """Write net, routes, scenery and configuration, all called `name`, into a directory; other files in it stay.

    Raises InputError where the line has no way for a train, no net can be built, or `out` cannot be written.
    """
    vehicles = vehicles_of(setup)
    types = [_type(kind, setup.line) for kind in {kind.id: kind for kind in setup.trains.values()}.values()]
    begin_s = min((vehicle.depart_s for vehicle in vehicles), default=0.0)
    end_s = max((train.calls[-1].last_s for train in setup.timetable.trains.values()), default=0)
    from_s, until_s, roads = max(0.0, begin_s - BEFORE_S), end_s + AFTER_S, roads_at(setup)
    with scratch("branchline-") as folder:
        net = net_for(setup.line, folder, roads)
        content = gzip.decompress(net.read_bytes()) if net.suffix == ".gz" else net.read_bytes()
    routes = {f"{name}.rou.xml": routes_xml(types, vehicles)}
    if roads:
        on_road = road_vehicles(roads, setup.seed, setup.today, from_s, until_s)
        on_road = tuple(one for one in on_road if from_s <= one.depart_s < until_s)
        routes[f"{name}.road.rou.xml"] = road_routes_xml(roads, on_road)
    files = {
        f"{name}.net.xml": content,
        **routes,
        f"{name}.add.xml": scenery_xml(setup.line),
        f"{name}.sumocfg": config_xml(name, from_s, until_s, tuple(routes)),
    }
    written = write_files(out, files)
    stops = sum(len(vehicle.stops) for vehicle in vehicles)
    return SumoDay(written, written[-1], len(vehicles), len(setup.timetable.trains), stops)


def vehicles_of(setup: Setup) -> tuple[SumoVehicle, ...]:
    """The day's sets as SUMO's vehicles; a set that leaves the line and comes again is two. Raises InputError."""
    try:
        drawn = drawn_up(setup, setup.line)
    except NoWay as error:
        raise InputError(
            setup.timetable.head.id, "", None, f"trains that the line has a way for: {error}"
        ) from error
    vehicles: list[SumoVehicle] = []
    for stock_id, duties in drawn.items():
        for number, chain in enumerate(_chains(duties)):
            name = stock_id if number == 0 else f"{stock_id}#{number + 1}"
            vehicles.append(_vehicle(setup, name, setup.trains[stock_id].id, chain))
    return tuple(vehicles)


def write_files(out: Path, files: dict[str, bytes]) -> tuple[Path, ...]:
    """Write files into a directory, each whole or not at all; other files in it stay. Raises InputError."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".branchline-", dir=out) as aside:
            for name, content in files.items():
                (Path(aside) / name).write_bytes(content)
            for name in files:
                (Path(aside) / name).replace(out / name)
    except OSError as error:
        expected = f"a directory that can be written ({error.strerror})"
        raise InputError(COMMAND_LINE, "OUT", out, expected) from error
    return tuple(out / name for name in files)


def _chains(duties: Sequence[Duty]) -> Iterator[list[Duty]]:
    """Duties from where a set comes onto the line to where it leaves it."""
    chain: list[Duty] = []
    for duty in duties:
        if chain and (duty.enters or chain[-1].leaves):
            yield chain
            chain = []
        chain.append(duty)
    if chain:
        yield chain


def _type(kind: TrainType, line: Line) -> VehicleType:
    """Nominal figures: SUMO's trains know neither gradients nor curves, load nor the fall of force with speed."""
    row = kind.row[0]
    mass_kg = float(row["mass_empty_kg"]) * (1.0 + float(row["rotating_mass_factor"]))
    force_n = float(row["traction_force_max_n"]) or float(row["traction_curve_n"].max())
    brakes = int(row["brake_notches"])
    service_mps2 = float(row["brake_deceleration_mps2"][brakes])
    return VehicleType(
        kind.id,
        float(row["length_m"]),
        min(line.max_speed_mps, float(row["speed_max_mps"])),
        max(force_n / mass_kg, 0.1),
        service_mps2,
        max(float(row["emergency_deceleration_mps2"]), service_mps2),
    )


def _vehicle(setup: Setup, name: str, type_id: str, chain: Sequence[Duty]) -> SumoVehicle:
    edges: list[str] = []
    stops: list[VehicleStop] = []
    for index, duty in enumerate(chain):
        mission = duty.mission
        own = [edge_id(step.piece_id, step.direction) for step in mission.path.steps]
        # Under a new number in the same direction it stands on the edge already.
        edges += own[1:] if edges and edges[-1] == own[0] else own
        following = chain[index + 1] if index + 1 < len(chain) else None
        stops += _stops(setup, duty, following, first=index == 0)
    first, last = chain[0].mission, chain[-1].mission
    here, there = first.targets[0], last.targets[-1]
    step = first.path.step_at(here.mark_m)
    leaves = chain[-1].leaves
    return SumoVehicle(
        name,
        type_id,
        first.number,
        max(0.0, chain[0].enter_s - (0.0 if chain[0].enters else BEFORE_S)),
        here.mark_m - step.start_m,
        tuple(edges),
        tuple(stops),
        None if leaves else there.mark_m - last.path.step_at(there.mark_m).start_m,
    )


def _stops(setup: Setup, duty: Duty, following: Duty | None, *, first: bool) -> Iterator[VehicleStop]:
    """Stops of one duty in order; where a set goes on as another train it stands until that leaves."""
    line, mission, dwell_s = setup.line, duty.mission, setup.timetable.head.dwell_min_s
    targets = [target for target in mission.targets if target.station_id is not None]
    found: list[tuple[float, VehicleStop]] = []
    for index, target in enumerate(targets):
        if index == 0 and not first:
            continue
        number, until_s, arrival_s = mission.number, target.departure_s, target.arrival_s
        begins = index == 0 and not duty.enters
        if arrival_s is None and until_s is not None and not begins:
            arrival_s = until_s - dwell_s
        if index == len(targets) - 1 and following is not None:
            number, until_s = following.mission.number, following.train.calls[0].last_s
        stop = _stop_of(line, target, mission.direction)
        # Arrivals after the timetable shorten no stop below the least; one that is planned shorter stays so.
        stands_s = (
            dwell_s if arrival_s is None or until_s is None else min(dwell_s, max(until_s - arrival_s, 0.0))
        )
        found.append(
            (target.mark_m, VehicleStop(stop, number, arrival_s, until_s, 0.0 if begins else stands_s))
        )
    found += _passed(line, duty)
    yield from (stop for _, stop in sorted(found, key=lambda pair: pair[0]))


def _passed(line: Line, duty: Duty) -> Iterator[tuple[float, VehicleStop]]:
    """Stations that a train runs through, each with the path coordinate of its mark, m."""
    mission = duty.mission
    for call in duty.train.calls:
        if call.stops:
            continue
        for track in line.stations[call.station_id].tracks:
            mark_m = track.marks_m.get(mission.direction)
            if track.piece_id in mission.path and mark_m is not None and call.track in (None, track.name):
                at_s = float(call.last_s)
                stop = VehicleStop(
                    stop_id(track, mission.direction), mission.number, at_s, at_s, 0.0, passes=True
                )
                yield mission.path.to_path_m(track.piece_id, mark_m), stop
                break


def _stop_of(line: Line, target: Target, direction: Direction) -> str:
    track = next(t for t in line.stations[target.station_id or ""].tracks if t.name == target.track)
    return stop_id(track, direction)
