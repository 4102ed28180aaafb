"""What the vehicle shows its unit of itself: what a train must not start or run without, and what it has to run with.

Sugiyama et al. 2017, 4.1.3 (2): vehicle and brakes are checked on board, and what is wrong with them is detected
(車両状態・ブレーキ状態). The inputs are fail-safe: a wire that breaks reads as not in order.
"""

from __future__ import annotations

import msgspec


class VehicleInputs(msgspec.Struct, frozen=True):
    """The inputs. `doors_closed`: closed and locked, all of them (戸閉); `brake_good`: pressure is as commanded;
    `motors_share`: of the motors in service, those cut out (主電動機開放) being left out.
    """

    doors_closed: bool = True
    brake_good: bool = True
    motors_share: float = 1.0

    @property
    def unfit(self) -> str:
        """What is not in order, in words; empty: the train may run."""
        wrong = (
            "" if self.doors_closed else "doors not closed",
            "" if self.brake_good else "brake not in order",
        )
        return ", ".join(filter(None, wrong))


IN_ORDER = VehicleInputs()
DOORS_OPEN = VehicleInputs(doors_closed=False).unfit
