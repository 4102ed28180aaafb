"""The train of table 1 of Yasunobu and others on its 1,000 m hop, under any law: what both experiments on it share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from network.files.toml_input import Record
from papers.parameter_sets import TABLE_1
from papers.single_hop import HopBench, HopWay, Planner, one_gradient
from papers.single_train import Bench
from vehicle.train_file import TrainType, load_train, shipped_train

HOP_M: Final = 1000.0  # 6.1
GRADIENTS_PERMILLE: Final = (10.0, 0.0, -10.0)
ORDERS_S: Final = (80.0, 85.0, 90.0, 95.0, 100.0)
NOMINAL_S: Final = 85.0  # figure 9, on the level


def paper_train() -> TrainType:
    """The train of table 1."""
    return load_train(shipped_train("hitachi_train"))


def paper_bench(
    law: str,
    law_settings: Record | None = None,
    drawn: Callable[[str, str], float] = lambda _law, _field: 0.0,
    deceleration_mps2: float = TABLE_1.driving.stop_deceleration_mps2,
    train: TrainType | None = None,
) -> Bench:
    """That train under a law, driven by the one set of parameters of all experiments on it.

    What the paper leaves open can be tried otherwise: the stop's `deceleration_mps2`, a `train` of other power.
    """
    driving = TABLE_1.driving.model_copy(update={"law": law, "stop_deceleration_mps2": deceleration_mps2})
    return Bench(
        paper_train() if train is None else train,
        driving,
        TABLE_1.unit,
        law_settings=law_settings,
        drawn=drawn,
    )


def paper_hops(
    law: str,
    gradient_permille: float = 0.0,
    law_settings: Record | None = None,
    planner: Planner | None = None,
    way: HopWay | None = None,
) -> HopBench:
    """The paper's hop on one gradient, or another way, under a law."""
    over = one_gradient(HOP_M, gradient_permille) if way is None else way
    return HopBench(paper_bench(law, law_settings), over, planner)
