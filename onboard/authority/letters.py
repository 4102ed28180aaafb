"""Between the authority machine and the telegrams: tokens, correlations, capabilities.

Invariant: an answer counts only for the request outstanding, by its correlation; tokens only grow. The machine is told
of each telegram how it relates to what is open, so that its own state stays small and symbolic.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple

from msgspec.structs import replace

from onboard import notes
from onboard.authority import records as sym
from onboard.authority.records import RequestKind
from onboard.plan import PointsNeeded
from radio import messages as radio
from radio.envelope import DropReason, Received

LOST_SIGHT: Final = (radio.RefusalReason.NOT_SIGNED_ON, radio.RefusalReason.STALE_TOKEN)
NOT_THE_NEWEST: Final = (
    radio.PointsRefusalReason.BAD_CAPABILITY,
    radio.PointsRefusalReason.OLD_TOKEN,
)
_WITH_TOKEN: Final = (notes.Holds, notes.Claimed, notes.Reported, notes.RouteHeld)


class Letter(NamedTuple):
    """A telegram to send."""

    destination: str
    message: radio.AnyMessage
    correlation: int


class CommandedPoints(NamedTuple):
    """A command as it was given: the token and code it goes by, and its correlation."""

    token: int
    mac: bytes
    correlation: int


class LetterNumbers(NamedTuple):
    """All that a boot knows of the numbers of its telegrams, to be kept and given back.

    `token`: the greatest taken; `correlation`: of the newest request, each open one keeps its own; tokens by section,
    codes by section and terminal, commands by points.
    """

    token: int = 0
    correlation: int = 0
    open: tuple[tuple[RequestKind, int], ...] = ()
    tokens: tuple[tuple[str, int], ...] = ()
    macs: tuple[tuple[tuple[str, str], bytes], ...] = ()
    commanded: tuple[tuple[str, CommandedPoints], ...] = ()


NO_NUMBERS: Final = LetterNumbers()


class Letters:
    """What one boot of a unit knows of the numbers of its telegrams; after a boot, none."""

    def __init__(self, unit_id: str, manager_id: str, numbers: LetterNumbers = NO_NUMBERS) -> None:
        self._unit_id: Final = unit_id
        self._manager_id: Final = manager_id
        self.token: int = numbers.token
        self._correlation = numbers.correlation
        self._open: dict[RequestKind, int] = dict(numbers.open)
        self._tokens: dict[str, int] = dict(numbers.tokens)
        self._macs: dict[tuple[str, str], bytes] = dict(numbers.macs)
        self._commanded: dict[str, CommandedPoints] = dict(numbers.commanded)
        self._heard: Received | None = None  # the telegram at hand

    @property
    def numbers(self) -> LetterNumbers:
        """All that is known, in one order."""
        return LetterNumbers(
            self.token,
            self._correlation,
            tuple(sorted(self._open.items(), key=lambda item: item[0].value)),
            tuple(sorted(self._tokens.items())),
            tuple(sorted(self._macs.items())),
            tuple(sorted(self._commanded.items())),
        )

    def read(self, heard: Received) -> sym.Event | sym.Ordered | None:
        """What a telegram means to the machines; None where it means nothing to a unit."""
        self._heard = heard
        reader = _READERS.get(type(heard.message))
        return None if reader is None else reader(self, heard, heard.message)

    def read_dropped(self, why: DropReason, source: str) -> sym.Event | None:
        """What a telegram means that took no effect; None where it means nothing to a unit."""
        self._heard = None
        calls = why is DropReason.EARLIER_BOOT and source == self._manager_id
        return sym.EarlierBootCalled() if calls else None

    def write(self, action: sym.SendRequest | sym.SendClaim | sym.SendRefusal | sym.SendCommand) -> Letter:
        """The telegram that an action asks for."""
        match action:
            case sym.SendRequest(request):
                return Letter(self._manager_id, self._request(request), self._open[request.ask])
            case sym.SendClaim(section_ids, leaving):
                query = self._heard
                token = 0 if section_ids is None else self.token
                claim = radio.LeavingClaim if leaving else radio.Claim
                return Letter(
                    self._manager_id, claim(section_ids, token), 0 if query is None else query.correlation
                )
            case sym.SendRefusal(route_id, reason):
                return Letter(self._manager_id, radio.OrderRefused(route_id, reason), 0)
            case sym.SendCommand(needed):
                known = self._commanded[needed.points_id]
                order = radio.PointsCommand(
                    needed.points_id, needed.position, needed.section_id, known.token, known.mac
                )
                return Letter(needed.terminal_id, order, known.correlation)

    def keep(self, action: sym.Renew | sym.Commit | sym.Take) -> None:
        """Number a new request, bind a command to its token, or take the token of the telegram at hand."""
        match action:
            case sym.Renew(ask):
                self._correlation += 1
                self._open[ask] = self._correlation
            case sym.Commit(needed):
                self._correlation += 1
                self._commanded[needed.points_id] = CommandedPoints(
                    self._tokens.get(needed.section_id, 0), self._mac(needed), self._correlation
                )
            case sym.Take(section_ids):
                self._take(section_ids)

    def with_token(self, note: notes.Note) -> notes.Note:
        """A line of the journal with the token that belongs to it."""
        match note:
            case notes.Proven(by_crew=False, points_id=points_id):
                return replace(note, token=self._commanded[points_id].token)
            case notes.Proven():
                return replace(note, token=self.token)
            case _ if isinstance(note, _WITH_TOKEN):
                return replace(note, token=self.token)
            case _:
                return note

    def _mac(self, needed: PointsNeeded) -> bytes:
        return self._macs.get((needed.section_id, needed.terminal_id), b"")

    def _request(self, request: sym.OpenRequest) -> radio.AnyMessage:
        match request.ask:
            case RequestKind.SIGN_ON:
                return radio.SignOn(self._unit_id, request.section_ids)
            case RequestKind.SIGN_OFF:
                return radio.SignOff(self._unit_id, self.token)
            case RequestKind.ROUTE:
                return radio.RouteRequest(
                    self._unit_id, request.subject, request.section_ids or (), self.token
                )
            case RequestKind.REPORT if request.subject:
                held = request.section_ids or ()
                return radio.NextTrainReport(held, self.token, request.swept, request.subject)
            case RequestKind.REPORT:
                return radio.HoldingReport(request.section_ids or (), self.token, request.swept)

    def _take(self, section_ids: tuple[str, ...]) -> None:
        """Its token for these sections and for those it has capabilities for."""
        message: Any = None if self._heard is None else self._heard.message
        if message is None:
            return
        self.token = message.token
        capabilities = getattr(message, "capabilities", ())
        renewed: set[str] = {c.section_id for c in capabilities} | set(section_ids)
        for key in [key for key in self._macs if key[0] in renewed]:
            del self._macs[key]
        self._tokens |= dict.fromkeys(renewed, self.token)
        self._macs |= {(c.section_id, c.terminal_id): c.mac for c in capabilities}

    # telegrams as the machine is told of them -------------------------------------------------------------------

    def _answers(self, ask: RequestKind, heard: Received) -> bool:
        return heard.correlation == self._open.get(ask, -1)

    def _signed_on(self, heard: Received, message: radio.SignOnAccepted) -> sym.Event:
        commandable = tuple(dict.fromkeys(c.section_id for c in message.capabilities))
        return sym.SignOnHeard(
            message.section_ids,
            commandable,
            self._answers(RequestKind.SIGN_ON, heard),
            message.token > self.token,
            message.on_sight,
        )

    def _sign_on_refused(self, heard: Received, message: radio.SignOnRefused) -> sym.Event:
        return self._refusal(RequestKind.SIGN_ON, "", heard, message)

    def _sign_off_refused(self, heard: Received, message: radio.SignOffRefused) -> sym.Event:
        lost = message.reason in LOST_SIGHT
        return sym.RefusalHeard(
            RequestKind.SIGN_OFF, "", message.reason.name, lost, self._answers(RequestKind.SIGN_OFF, heard)
        )

    def _route_refused(self, heard: Received, message: radio.RouteRefused) -> sym.Event:
        return self._refusal(RequestKind.ROUTE, message.route_id, heard, message)

    def _refusal(
        self,
        ask: RequestKind,
        subject: str,
        heard: Received,
        message: radio.RouteRefused | radio.SignOnRefused,
    ) -> sym.Event:
        why = message.reason.name.lower().replace("_", " ")
        if message.section_id is not None:
            why += f": section {message.section_id}"
        if message.holder is not None:
            why += f" of {message.holder}"
        return sym.RefusalHeard(ask, subject, why, message.reason in LOST_SIGHT, self._answers(ask, heard))

    def _signed_off(self, heard: Received, _message: radio.SignOffAccepted) -> sym.Event:
        return sym.SignOffHeard(self._answers(RequestKind.SIGN_OFF, heard))

    def _granted(self, heard: Received, message: radio.RouteGranted) -> sym.Event:
        return sym.GrantHeard(
            message.route_id,
            message.section_ids,
            tuple(dict.fromkeys(c.section_id for c in message.capabilities)),
            self._answers(RequestKind.ROUTE, heard),
            heard.fresh,
            message.token > self.token,
            message.on_sight,
        )

    def _confirmed(self, heard: Received, message: radio.HoldingConfirmed) -> sym.Event:
        answers = self._answers(RequestKind.REPORT, heard)
        newer = message.token > self.token
        return sym.ConfirmationHeard(message.section_ids, answers, newer, message.contested, message.on_sight)

    def _track_ordered(self, heard: Received, message: radio.TrackOrdered) -> sym.Ordered:
        answers = self._answers(RequestKind.ROUTE, heard)
        return sym.TrackChangeOrdered(message.route_id, message.instead, answers)

    def _train_ordered(self, heard: Received, message: radio.TrainOrdered) -> sym.Ordered:
        return sym.TrainEndOrdered(message.route_id, message.train, self._answers(RequestKind.ROUTE, heard))

    def _taken_back(self, _heard: Received, message: radio.RouteTakenBack) -> sym.Ordered:
        return sym.TakeBackOrdered(message.route_id, message.token == self.token, message.hold_s)

    def _proof(self, heard: Received, message: radio.PointsProof) -> sym.Event:
        good = message.locked and message.detected and message.position is not None
        position = message.position.value if good and message.position is not None else None
        mine = self._mine(message) and heard.correlation == self._commanded[message.points_id].correlation
        return sym.ProofHeard(message.points_id, heard.source, position, mine)

    def _points_refused(self, heard: Received, message: radio.PointsRefused) -> sym.Event:
        why = message.reason.name.lower().replace("_", " ")
        return sym.PointsDenialHeard(
            message.points_id, heard.source, why, self._mine(message), message.reason in NOT_THE_NEWEST
        )

    def _mine(self, message: radio.PointsProof | radio.PointsRefused) -> bool:
        known = self._commanded.get(message.points_id)
        return known is not None and known.token == message.token


_READERS: Final[
    Mapping[type[radio.AnyMessage], Callable[[Letters, Received, Any], sym.Event | sym.Ordered]]
] = {
    radio.SignOnAccepted: Letters._signed_on,
    radio.SignOnRefused: Letters._sign_on_refused,
    radio.SignOffAccepted: Letters._signed_off,
    radio.SignOffRefused: Letters._sign_off_refused,
    radio.RouteGranted: Letters._granted,
    radio.RouteRefused: Letters._route_refused,
    radio.TrackOrdered: Letters._track_ordered,
    radio.TrainOrdered: Letters._train_ordered,
    radio.RouteTakenBack: Letters._taken_back,
    radio.PointsProof: Letters._proof,
    radio.PointsRefused: Letters._points_refused,
    radio.HoldingConfirmed: Letters._confirmed,
    radio.Contested: lambda _letters, _heard, message: sym.ContestHeard(message.section_ids),
    radio.ClaimQuery: lambda _letters, _heard, _message: sym.QueryHeard(),
    radio.Restarted: lambda _letters, _heard, _message: sym.PeerRestarted(),
}
