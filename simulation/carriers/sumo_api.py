"""SUMO's own interface, twice: libsumo in this process, or TraCI to a sumo-gui whose window shows the run.

Both have the same functions with the same names; libsumo's wheels for Linux are built without a window.
"""

from __future__ import annotations

import io
import os
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from network.errors import COMMAND_LINE, InputError

if TYPE_CHECKING:
    import libsumo

STEP_DELAY_MS: Final = 20  # for a step of 0.1 s: five times as fast as the clock, to begin with
PROGRAM: Final = "sumo-gui"


@dataclass(frozen=True, slots=True)
class SumoApi:
    """What the carrier calls, typed as libsumo has it."""

    start: Callable[[Sequence[str]], object]
    step: Callable[..., object]
    set_speed: Callable[[str, float], object]
    colliding: Callable[[], int]
    arrived: Callable[[], Sequence[str]]
    close: Callable[[], None]
    simulation: type[libsumo.simulation]
    lane: type[libsumo.lane]
    route: type[libsumo.route]
    vehicle: type[libsumo.vehicle]
    vehicletype: type[libsumo.vehicletype]
    trafficlight: type[libsumo.trafficlight]


def in_process() -> SumoApi:
    """SUMO as a library, without a window; what every step calls without libsumo's layer of Python over it."""
    import libsumo
    from libsumo import _libsumo

    return SumoApi(
        libsumo.start,
        _libsumo.simulation_step,
        _libsumo.vehicle_setSpeed,
        _libsumo.simulation_getCollidingVehiclesNumber,
        _libsumo.simulation_getArrivedIDList,
        libsumo.close,
        libsumo.simulation,
        libsumo.lane,
        libsumo.route,
        libsumo.vehicle,
        libsumo.vehicletype,
        libsumo.trafficlight,
    )


@dataclass(frozen=True, slots=True)
class GuiWindow:
    """What a window shows beside the trains, an additional file, and how long, ms, it takes over a step at first."""

    scenery: Path | None = None
    delay_ms: int = STEP_DELAY_MS


def in_window(window: GuiWindow) -> SumoApi:
    """sumo-gui in a process of its own.

    Raises InputError where there is no sumo-gui or no display.
    """
    program = _program()
    if not os.environ.get("DISPLAY") and sys.platform.startswith("linux"):
        expected = (
            "a screen to draw on: the variable DISPLAY names none; leave --gui out, or run it under one"
        )
        raise InputError(COMMAND_LINE, "--gui", None, expected)
    # TraCI carries no types of its own; its names and parameters are libsumo's.
    api: Any = import_module("traci")

    def start(command: Sequence[str]) -> None:
        shown = [str(program), *command[1:], "--start", "--quit-on-end", "--delay", str(window.delay_ms)]
        if window.scenery is not None:
            shown += ["--additional-files", str(window.scenery)]
        os.environ.setdefault("SUMO_HOME", str(program.parent.parent))
        # TraCI tells of its tries to connect on stdout, and sumo-gui of itself: neither is this program's answer.
        with redirect_stdout(io.StringIO()), tempfile.TemporaryFile() as said:
            api.start(shown, stdout=said)

    return SumoApi(
        start,
        api.simulationStep,
        api.vehicle.setSpeed,
        api.simulation.getCollidingVehiclesNumber,
        api.simulation.getArrivedIDList,
        api.close,
        api.simulation,
        api.lane,
        api.route,
        api.vehicle,
        api.vehicletype,
        api.trafficlight,
    )


def _program() -> Path:
    """Where sumo-gui is: in the package eclipse-sumo. Raises InputError."""
    spec = find_spec("sumo")
    for folder in (spec.submodule_search_locations or ()) if spec else ():
        for name in (PROGRAM, f"{PROGRAM}.exe"):
            if (found := Path(folder) / "bin" / name).is_file() and find_spec("traci") is not None:
                return found
    expected = "sumo-gui, which is not installed: pip install 'branchline[net]'"
    raise InputError(COMMAND_LINE, "--gui", None, expected)
