"""What radio takes of a blocking time on average: from the parameters of the air and the repeats of the parties.

A telegram is under way for `OnAverage.delay_s`. One that is lost is sent again after `REPEAT_S`, until it is
answered; with a share p of telegrams lost, a request gets through after `REPEAT_S * p / (1 - p)` on average. If its
answer is lost, both ways must come again: `p * REPEAT_S / (1 - p)^2`. The machines themselves take no time.
"""

from __future__ import annotations

from dataclasses import dataclass

from onboard.authority.tables import REPEAT_S
from radio.air import OnAverage


@dataclass(frozen=True, slots=True)
class Links:
    """Mean times of telegrams, s: `delay_s` on the way, `request_s` until one is sent that gets through, `answer_s` for
    answers that are lost.
    """

    delay_s: float
    request_s: float = 0.0
    answer_s: float = 0.0

    @staticmethod
    def of(radio: OnAverage) -> Links:
        """Those of telegrams as they are on average, away from places where no network reaches."""
        lost = min(radio.loss_p, 0.99)  # nothing gets through beyond that, and no mean says how long it takes
        return Links(radio.delay_s, REPEAT_S * lost / (1.0 - lost), lost * REPEAT_S / (1.0 - lost) ** 2)

    @property
    def ask_s(self) -> float:
        """From the wish for a route until it is held: request, air, grant."""
        return self.request_s + self.delay_s + self.grant_s

    @property
    def grant_s(self) -> float:
        """From the manager's grant until the unit counts it."""
        return self.delay_s + self.answer_s

    @property
    def command_s(self) -> float:
        """From a command until the terminal takes it."""
        return self.request_s + self.delay_s

    @property
    def proof_s(self) -> float:
        """From the points being locked until the unit has the proof."""
        return self.delay_s + self.answer_s

    @property
    def report_s(self) -> float:
        """From a report until the register has it."""
        return self.request_s + self.delay_s

    def set_s(self, throw_s: float) -> float:
        """From a command until the proof, with points that take so long to throw; 0 s: they lie right."""
        return self.command_s + throw_s + self.proof_s
