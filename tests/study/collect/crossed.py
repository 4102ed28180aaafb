"""A journal of level crossings, whose figures are counted by hand: seconds from midnight."""

from typing import Final

from onboard.notes import Moving
from simulation.events import WORLD, BarrierState, CrossingBarriers, CrossingEntered, CrossingLamps
from simulation.journal import Journal

DOWN, DOWN_NOW = BarrierState.LOWERING, BarrierState.LOWERED
UP, UP_NOW = BarrierState.RISING, BarrierState.RAISED
END_S: Final = 10_000.0


def lamps(journal: Journal, t_s: float, crossing: str, *, lit: bool) -> None:
    journal.write(t_s, WORLD, CrossingLamps(crossing_id=crossing, lit=lit))


def barriers(journal: Journal, t_s: float, crossing: str, state: BarrierState) -> None:
    journal.write(t_s, WORLD, CrossingBarriers(crossing_id=crossing, state=state))


def front(journal: Journal, t_s: float, crossing: str, unit: str) -> None:
    journal.write(t_s, WORLD, CrossingEntered(unit_id=unit, crossing_id=crossing, speed_mps=10.0))


def crossed() -> Journal:
    """C1 has barriers: K1, which starts 10 s after its lamps, comes over the hour; then two trains come in one closure,
    K2 and K1, and lamps are lit again for K2 before the barriers are up. C2 has lamps alone. C3 shows nothing when K1
    comes, and C4 never opens again.
    """
    journal = Journal()
    journal.write(3000.0, "K2", Moving())
    lamps(journal, 3580.0, "C1", lit=True)
    barriers(journal, 3580.0, "C1", DOWN)
    journal.write(3590.0, "K1", Moving())
    barriers(journal, 3595.0, "C1", DOWN_NOW)
    front(journal, 3610.0, "C1", "K1")
    lamps(journal, 3620.0, "C1", lit=False)
    barriers(journal, 3620.0, "C1", UP)
    barriers(journal, 3628.0, "C1", UP_NOW)

    lamps(journal, 4000.0, "C1", lit=True)
    barriers(journal, 4000.0, "C1", DOWN)
    barriers(journal, 4015.0, "C1", DOWN_NOW)
    front(journal, 4035.0, "C1", "K2")
    front(journal, 4060.0, "C1", "K1")
    lamps(journal, 4070.0, "C1", lit=False)
    barriers(journal, 4070.0, "C1", UP)
    lamps(journal, 4074.0, "C1", lit=True)
    barriers(journal, 4074.0, "C1", DOWN)
    barriers(journal, 4089.0, "C1", DOWN_NOW)
    front(journal, 4109.0, "C1", "K2")
    lamps(journal, 4120.0, "C1", lit=False)
    barriers(journal, 4120.0, "C1", UP)
    barriers(journal, 4128.0, "C1", UP_NOW)

    lamps(journal, 7190.0, "C2", lit=True)
    front(journal, 7230.5, "C2", "K2")
    lamps(journal, 7240.0, "C2", lit=False)
    front(journal, 7300.0, "C3", "K1")
    lamps(journal, 9000.0, "C4", lit=True)
    return journal
