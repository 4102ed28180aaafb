"""What is said while a plan is looked for: what has been found so far, and below what there is none."""

from __future__ import annotations

from collections.abc import Callable

from ortools.sat.python import cp_model

Tell = Callable[[str], None]  # takes what is being done now


def tell_nobody(_text: str) -> None:
    """Where nobody waits for it."""


class FoundSoFar(cp_model.CpSolverSolutionCallback):
    """Tells the best plan and the bound as they come, in units of which one counts `unit`; the search is the same."""

    def __init__(self, tell: Tell, unit: int, counted: str) -> None:
        super().__init__()
        self._tell = tell
        self._unit = unit
        self._counted = counted
        self._found = ""
        self._bound = 0.0

    def on_solution_callback(self) -> None:
        """A better plan."""
        self._found = f"moves of {self.objective_value / self._unit:.0f} s in all found, "
        self.on_bound(self._bound)

    def on_bound(self, bound: float) -> None:
        """A plan needs so much at least."""
        self._bound = max(self._bound, bound)
        self._tell(f"{self._found}no plan with less than {self._bound / self._unit:.0f} s{self._counted}")
