"""Behaviours of block manager and point terminals that can be taken away."""

from collections.abc import Iterable, Mapping, Sequence

import msgspec
import pytest

from host import device, store
from host.store import PartyStore
from network.model import Position
from onboard.authority import agreement, letters
from onboard.authority import records as sym
from onboard.authority.letters import Letters
from onboard.unit import OnboardUnit, Report, Telegram, UnitAnswer
from radio.keys import MAC_BYTES
from radio.messages import PointsCommand, RefusalReason, SignOff
from radio.noted import TookEffect
from simulation import duties, injector, staff
from simulation.faults.commissioning import ServiceRecord
from simulation.faults.script import Act
from tests.system.switchboard import K1_ON_P7_S, K2_ON_P7_S, switch
from verify.restored import RESTORED
from wayside import acts, barring, block_manager, entering, leaving, point_terminal, reentry, register
from wayside.actions import Action, Show
from wayside.config import ManagerConfig
from wayside.register import Register, UnitStanding
from wayside.said import Freed, PointsDetected


def _restore(patch: pytest.MonkeyPatch, name: str) -> None:
    for where, what, value in RESTORED[name]():
        patch.setattr(where, what, value)


# block manager ----------------------------------------------------------------------------------------------


@switch
def grants_what_another_holds(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Register, "other_holder", lambda *_: None)


@switch
def lets_all_come_in(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(entering, "EXCLUDES", False)


@switch
def grants_while_undefined(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Register, "defined", property(lambda _: True))


@switch
def starts_with_every_section_free(patch: pytest.MonkeyPatch) -> None:
    start = register.start

    def afresh(
        config: ManagerConfig, epoch: int, keys: Mapping[str, bytes], *_kept: Iterable[str] | None
    ) -> Register:
        return msgspec.structs.replace(start(config, epoch, keys, ()), restoring=False)

    patch.setattr(device, "start_register", afresh)
    patch.setattr(register, "UNKNOWN_UNIT", register.RegisteredUnit(UnitStanding.OUTSIDE))


@switch
def asks_for_no_place(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(acts, "_senseless", lambda *_: None)
    patch.setattr(reentry, "in_station", lambda *_: True)

    def whoever_agrees(register: Register, unit_id: str) -> frozenset[str] | None:
        entered = reentry.entered_for(register, unit_id)
        words = reentry.words_for(register, unit_id).values()
        return entered if sum(word == entered for word in words) > 1 else None

    patch.setattr(reentry, "agreed", whoever_agrees)


@switch
def leaves_the_line_unswept(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(reentry, "to_be_swept", lambda register, _sections: (register, ()))


@switch
def tells_nobody_of_a_contradiction(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Register, "contested", lambda _self, _unit_id: ())


@switch
def accepts_a_picture_without_the_silent(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(reentry, "vouched", lambda *_: True)


@switch
def tokens_begin_anew(patch: pytest.MonkeyPatch) -> None:
    def next_token(self: Register) -> tuple[Register, int]:
        return msgspec.structs.replace(self, counter=self.counter + 1), self.counter + 1

    patch.setattr(Register, "next_token", next_token)


@switch
def silence_frees(patch: pytest.MonkeyPatch) -> None:
    """A lease: what a unit holds is free when it has been silent for 15 s."""
    step, heard_s = block_manager.step, dict[str, float]()

    def leased(state: Register, event: block_manager.Event, now_s: float) -> reentry.Step:
        if isinstance(event, block_manager.Heard):
            heard_s[event.unit_id] = now_s
        lapsed: list[Action] = []
        for unit_id, last_s in heard_s.items():
            if now_s - last_s > 15.0 and (held := state.held_by(unit_id)):
                state = state.with_held(unit_id, ())
                lapsed.append(Show(Freed(unit_id=unit_id, section_ids=held)))
        state, actions = step(state, event, now_s)
        return state, (*lapsed, *actions)

    patch.setattr(block_manager, "step", leased)


@switch
def frees_a_portal_at_the_sign_off(patch: pytest.MonkeyPatch) -> None:
    """The manager takes a train as gone as soon as it may go."""

    def signed_off(state: Register, heard: block_manager.Heard[SignOff]) -> reentry.Step:
        state, said = leaving.sign_off(state, heard)
        if state.unit(heard.unit_id).standing is not UnitStanding.LEAVING:
            return state, said
        state, freed = leaving.left_line(state, heard.unit_id)
        return state, (*said, *freed)

    table = {**block_manager.TELEGRAMS, (UnitStanding.REPORTED, SignOff): signed_off}
    patch.setattr(block_manager, "TELEGRAMS", table)


@switch
def counts_no_train_out(patch: pytest.MonkeyPatch) -> None:
    """The contact at the boundary says nothing."""
    patch.setattr(leaving, "boundary_passed", lambda register, _portal: (register, ()))


@switch
def nobody_knows_what_is_left_out(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(injector.Injector, "_unsaid", lambda _self, _act: ())


@switch
def one_person_suffices(patch: pytest.MonkeyPatch) -> None:
    def entered(register: Register, unit_id: str) -> frozenset[str] | None:
        return reentry.entered_for(register, unit_id) if reentry.words_for(register, unit_id) else None

    patch.setattr(reentry, "agreed", entered)


@switch
def bars_nobody(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(barring, "bars_after_word", lambda bars, *_, **__: bars)


@switch
def frees_what_a_barred_unit_holds(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(acts, "_shut_out", lambda register, event: register.with_held(event.unit_id, ()))


@switch
def refuses_everything(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(block_manager, "_against", lambda *_: (RefusalReason.HELD, None, None))


@switch
def takes_the_end_of_a_claim_for_a_release(patch: pytest.MonkeyPatch) -> None:
    """Persons may not say of a train on open line that it is not where its unit falsely claims to be."""
    patch.setattr(acts, "_given_back", acts._freed)


# point terminal -----------------------------------------------------------------------------------------------


@switch
def commands_what_it_does_not_hold(patch: pytest.MonkeyPatch) -> None:
    """Given: K2, refused because K1 is on its way over P7, commands P7 with a capability that it made up."""
    advance = OnboardUnit.advance

    def rogue(self: OnboardUnit, now_s: float, telegrams: Sequence[bytes], sensed: Report) -> UnitAnswer:
        answer = advance(self, now_s, telegrams, sensed)
        refused = any(isinstance(n, TookEffect) and n.kind == "RouteRefused" for n in answer.notes)
        if self.unit_id != "K2" or now_s < K1_ON_P7_S or not refused:
            return answer
        order = PointsCommand("P7", Position.REVERSE, "7", self._letters.token + 10, bytes(MAC_BYTES))
        data = self._endpoint.seal("B-W", order, now_s)
        made_up = Telegram("B-W", data)
        return msgspec.structs.replace(answer, telegrams=(*answer.telegrams, made_up))

    patch.setattr(OnboardUnit, "advance", rogue)


@switch
def throws_for_anyone(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(point_terminal, "refusal", lambda *_: None)


@switch
def repeats_an_old_command(patch: pytest.MonkeyPatch) -> None:
    """Given: K1 keeps its command of P7, and repeats it long after it gave the section back."""
    advance, kept = OnboardUnit.advance, list[tuple[str, PointsCommand]]()
    write = Letters.write

    def writing(self: Letters, action: sym.SendRequest | sym.SendClaim | sym.SendCommand) -> letters.Letter:
        letter = write(self, action)
        message = letter.message
        if self._unit_id == "K1" and isinstance(message, PointsCommand) and message.points_id == "P7":
            kept[:] = [(letter.destination, message)]
        return letter

    def repeating(self: OnboardUnit, now_s: float, telegrams: Sequence[bytes], sensed: Report) -> UnitAnswer:
        answer = advance(self, now_s, telegrams, sensed)
        if self.unit_id != "K1" or now_s < K2_ON_P7_S or not kept:
            return answer
        destination, order = kept.pop()
        again = Telegram(destination, self._endpoint.seal(destination, order, now_s))
        return msgspec.structs.replace(answer, telegrams=(*answer.telegrams, again))

    patch.setattr(Letters, "write", writing)
    patch.setattr(OnboardUnit, "advance", repeating)


@switch
def obeys_an_old_token(patch: pytest.MonkeyPatch) -> None:
    """The capability is authentic; that a newer holder has commanded since is not looked at."""
    _restore(patch, "old-token-obeyed")


@switch
def proves_what_it_has_not_detected(patch: pytest.MonkeyPatch) -> None:
    _restore(patch, "proves-undetected")


# durable state ------------------------------------------------------------------------------------------------


@switch
def takes_a_lost_store_for_a_first_start(patch: pytest.MonkeyPatch) -> None:
    def anew(kept: PartyStore, _called: str) -> PartyStore:
        if kept.load().commissioned == 0:
            store.commission(kept)
        return kept

    patch.setattr("host.boot.commissioned", anew)
    patch.setattr("host.units.commissioned", anew)


@switch
def knows_not_who_relies_on_points(patch: pytest.MonkeyPatch) -> None:
    """A terminal that has lost its memory is told the last tokens, and not who had its points proven."""
    told = ServiceRecord.vital

    def tokens_alone(self: ServiceRecord, party_id: str) -> bytes:
        memory = msgspec.msgpack.decode(told(self, party_id), type=point_terminal.TerminalMemory)
        return msgspec.msgpack.encode(point_terminal.TerminalMemory(memory.tokens))

    patch.setattr(ServiceRecord, "vital", tokens_alone)


@switch
def staff_say_no_more_than_what_is_so(patch: pytest.MonkeyPatch) -> None:
    """People do not say of a silent train that it holds what their word cannot free."""
    patch.setattr(staff, "IN_STATION", "said by nobody")


@switch
def keeps_what_others_say_that_it_holds(patch: pytest.MonkeyPatch) -> None:
    """A unit that hears that the register has more than it holds does not give that back."""
    patch.setattr(staff.Staff, "_taken_back", lambda *_: None)  # nor does who has said it take it back
    patch.setattr(agreement, "report_now", lambda state: (state, ()))


@switch
def tells_no_unit_what_persons_added(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(reentry, "TELLS_OF_MORE", False)


@switch
def staff_unbar_at_once(patch: pytest.MonkeyPatch) -> None:
    """Whether or not it is known by then what the unit holds, and whether or not they were heard who said it."""
    patch.setattr(staff, "_OF_THE_LINE", ())
    see = staff.Staff._see_to_bars

    def whoever_is_awaited(self: staff.Staff, t_s: float) -> None:
        awaited, self._awaited = self._awaited, {}
        see(self, t_s)
        self._awaited = awaited

    patch.setattr(staff.Staff, "_see_to_bars", whoever_is_awaited)


@switch
def staff_unbar_nobody_while_restoring(patch: pytest.MonkeyPatch) -> None:
    """Even where its own word alone could say what it holds."""
    see = staff.Staff._see_to_bars

    def as_if_running(self: staff.Staff, t_s: float) -> None:
        restores, self._restores = self._restores, False
        see(self, t_s)
        self._restores = restores

    patch.setattr(staff.Staff, "_see_to_bars", as_if_running)


@switch
def overtakes_before_a_portal(patch: pytest.MonkeyPatch) -> None:
    """Of those that stand behind each other outside, whoever looks first comes in."""
    patch.setattr(duties, "is_behind", lambda _slot, _queue: False)


@switch
def staff_call_nobody_back(patch: pytest.MonkeyPatch) -> None:
    """Who has said something else of a silent unit is not asked to say what is so."""
    patch.setattr(staff, "_WORDS", ())


@switch
def staff_speak_from_memory(patch: pytest.MonkeyPatch) -> None:
    """Of where trains stand and what they hold, staff say what they saw before the time that their word takes."""
    add = injector.Injector.add

    def as_seen_first(self: injector.Injector, act: Act, at_s: float, look: object = None) -> None:
        add(self, act, at_s, None if look is None else lambda: act)

    patch.setattr(injector.Injector, "add", as_seen_first)


@switch
def looks_at_points_in_silence(patch: pytest.MonkeyPatch) -> None:
    """A terminal that was off says nothing of points that lie otherwise than it proved before."""
    row = point_terminal.PointsState.REMEMBERED, PointsDetected
    patch.setattr(point_terminal, "TABLE", {**point_terminal.TABLE, row: point_terminal._detect_committed})


@switch
def withdraws_once(patch: pytest.MonkeyPatch) -> None:
    """A terminal says once that points lie otherwise than it has proved, whether or not that is heard."""
    patch.setattr(point_terminal, "WITHDRAWN_AGAIN_S", 86_400.0)
