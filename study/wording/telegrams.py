"""What telegrams are called (電文)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from radio import messages as radio
from study.wording.phrase import Phrase

_JAPANESE: Final[Mapping[type[radio.Message], str]] = {
    radio.RouteRequest: "閉そく確保要求",
    radio.RouteGranted: "閉そく確保通知",
    radio.RouteRefused: "閉そく確保拒否",
    radio.HoldingReport: "確保区間報告",
    radio.HoldingConfirmed: "確保区間確認",
    radio.SignOn: "在線登録",
    radio.SignOnAccepted: "在線登録受付",
    radio.SignOnRefused: "在線登録拒否",
    radio.SignOff: "在線抹消",
    radio.SignOffAccepted: "在線抹消受付",
    radio.SignOffRefused: "在線抹消拒否",
    radio.ClaimQuery: "確保区間照会",
    radio.Claim: "確保区間回答",
    radio.PointsCommand: "転てつ機制御",
    radio.PointsProof: "転てつ機照査",
    radio.PointsRefused: "転てつ機制御拒否",
    radio.Restarted: "再起動通知",
    radio.Contested: "矛盾通知",
}
TELEGRAMS: Final[Mapping[str, Phrase]] = {
    message.__name__: Phrase(message.__name__, japanese) for message, japanese in _JAPANESE.items()
}


def telegram(kind: str) -> Phrase:
    """A kind of telegram in words."""
    return TELEGRAMS.get(kind, Phrase(kind))
