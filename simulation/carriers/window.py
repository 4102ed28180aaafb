"""SUMO as the carrier with a window on the run: the same carrier over TraCI, which may be lost with the window."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path

from network.model import Direction
from simulation.carriers.carrier import Truth
from simulation.carriers.lost import CarrierLostError
from simulation.carriers.road import Road
from simulation.carriers.sumo import SumoCarrier
from simulation.carriers.sumo_api import GuiWindow, in_window
from simulation.carriers.sumo_road import SumoRoadCarrier


@contextmanager
def _window_open() -> Generator[None]:
    """A window that is closed ends the run. Raises CarrierLostError."""
    lost: type[Exception] = import_module("traci.exceptions").FatalTraCIError
    try:
        yield
    except (lost, ConnectionError) as error:
        raise CarrierLostError("sumo-gui is gone: its window was closed, or it could not open one") from error


class WindowCarrier:
    """A SUMO simulation in sumo-gui. Each method is that of `SumoCarrier`."""

    def __init__(self, net: Path, begin_s: float, window: GuiWindow, road: Road | None = None) -> None:
        api = in_window(window)
        with _window_open():
            self._inner = (
                SumoCarrier(net, begin_s, api) if road is None else SumoRoadCarrier(net, begin_s, road, api)
            )

    def insert(
        self, unit_id: str, pieces: Sequence[str], direction: Direction, offset_m: float, length_m: float
    ) -> None:
        """Put a standing train on the net."""
        with _window_open():
            self._inner.insert(unit_id, pieces, direction, offset_m, length_m)

    def run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> int:
        """Execute the speeds step by step, watching for collisions."""
        with _window_open():
            return self._inner.run(columns, steps)

    def truth(self, unit_id: str) -> Truth:
        """Where the front is, as SUMO has it."""
        with _window_open():
            return self._inner.truth(unit_id)

    def reroute(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Change what lies ahead."""
        with _window_open():
            self._inner.reroute(unit_id, pieces, direction)

    def reverse(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Change ends in place."""
        with _window_open():
            self._inner.reverse(unit_id, pieces, direction)

    def remove(self, unit_id: str) -> None:
        """Take a train off the line."""
        with _window_open():
            self._inner.remove(unit_id)

    def collisions(self) -> tuple[str, ...]:
        """What SUMO's own check found."""
        return self._inner.collisions()

    def close(self) -> None:
        """End the simulation, if the window is still there."""
        with suppress(CarrierLostError), _window_open():
            self._inner.close()
