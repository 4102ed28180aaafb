"""Messages survive their codec, are told apart, and are short."""

import msgspec
import pytest

from network.model import Position
from radio import messages as m

EXAMPLES: list[m.AnyMessage] = [
    m.RouteRequest("u1", "R", ("a", "b")),
    m.RouteGranted("R", ("a", "b"), 1 << 32, (m.Capability("t", "a", bytes(16)),)),
    m.RouteGranted("R", ("a", "b"), 1 << 32, (), ("b",)),
    m.RouteRefused("R", m.RefusalReason.HELD, "a", "u2"),
    m.HoldingReport(("a",), 5),
    m.HoldingReport(("a",), 5, ("b",)),
    m.HoldingConfirmed(("a",), 5),
    m.HoldingConfirmed(("a", "b"), 5, ("b",)),
    m.SignOn("u1", None),
    m.SignOn("u1", ("a",), 5),
    m.SignOnAccepted(("a",), 5, "R", ()),
    m.SignOnAccepted(("a", "b"), 5, None, (), ("b",)),
    m.SignOnRefused(m.RefusalReason.CLAIM_NEEDED),
    m.SignOff("u1", 5),
    m.SignOffAccepted(),
    m.SignOffRefused(m.RefusalReason.STILL_HOLDING),
    m.ClaimQuery(),
    m.Claim(None, 0),
    m.Claim(("a",), 5),
    m.LeavingClaim(("a",), 5),
    m.PointsCommand("p", Position.REVERSE, "a", 5, bytes(16)),
    m.PointsProof("p", None, False, False, 5),
    m.PointsRefused("p", m.PointsRefusalReason.OLD_TOKEN, 5),
    m.Restarted(),
    m.Contested(("a", "b")),
    m.TrackOrdered("R", "S"),
    m.RouteTakenBack("R", 5, 30.0),
    m.OrderRefused("R", m.OrderRefusalReason.NOT_HELD),
    m.TrainOrdered("R", "2M"),
    m.NextTrainReport(("A",), 7, (), "2M"),
    m.CrossingRequest(40.0, 22.5),
    m.CrossingProof(True, 12.0),
    m.CrossingOver(True),
    m.CrossingOverHeard(),
    m.CrossingClear(True, 12.0),
]


@pytest.mark.parametrize("message", EXAMPLES, ids=lambda message: type(message).__name__)
def test_round_trip(message: m.AnyMessage) -> None:
    decoded = msgspec.msgpack.decode(msgspec.msgpack.encode(message), type=m.AnyMessage)
    assert decoded == message
    assert type(decoded) is type(message)


def test_every_message_has_an_example_and_its_own_tag() -> None:
    types = {*m.Message.__subclasses__(), *m.Claim.__subclasses__()}
    assert types == {type(message) for message in EXAMPLES}
    assert len({kind.__struct_config__.tag for kind in types}) == len(types)


def test_messages_are_immutable() -> None:
    with pytest.raises(AttributeError):
        setattr(EXAMPLES[3], "token", 6)  # noqa: B010


def test_a_report_of_one_section_takes_a_dozen_bytes() -> None:
    assert len(msgspec.msgpack.encode(m.HoldingReport(("a",), 1 << 32))) <= 16
