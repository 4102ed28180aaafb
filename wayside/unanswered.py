"""Orders to go on as another train that a unit has not answered: nobody knows whether it has heard of them.

Invariant: while one is out, nothing is granted to others after which not all could finish either way.
"""

from __future__ import annotations

from wayside.certificate import STEPS_MAX, CertificateProof, finishing_order
from wayside.journeys import Days, Stands
from wayside.register import Register

EITHER_WAY = True  # off: who was ordered to go on as another train counts as if it were not


def in_doubt(register: Register, days: Days, after: Stands, index: int) -> int | None:
    """A stock that was ordered to go on as another train, if not all could finish should it do so `after` the grant to
    stock `index`; None: all can either way.
    """
    for other, unit_id in enumerate(days.unit_ids) if EITHER_WAY else ():
        next_train = register.trip(unit_id).next_train if other != index else ""
        cut = days.with_cut(other, after.at[other], next_train) if next_train else None
        if cut is None:
            continue
        found = finishing_order(after.trains(cut), STEPS_MAX)
        if found.proof is not CertificateProof.ORDER:
            return other
    return None
