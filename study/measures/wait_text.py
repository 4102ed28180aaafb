"""A wait as one sentence, in English or Japanese (なぜ待っているか)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from network.clock import clock
from study.record.wait import Asked, Cause, Wait
from study.wording.phrase import Language, Names, Phrase
from study.wording.reasons import reason
from wayside.config import MANAGER_ID

_ASKED: Final[Mapping[Asked, Phrase]] = {
    Asked.NOTHING: Phrase("its command", "制御"),
    Asked.SIGN_ON: Phrase("its sign-on", "在線登録"),
    Asked.SIGN_OFF: Phrase("its sign-off", "在線抹消"),
    Asked.ROUTE: Phrase("its request for a route", "進路"),
    Asked.REPORT: Phrase("its report of what it holds", "確保区間の報告"),
}
# Whoever and whatever may be missing has its own clause (`since`, `until`, `why`), which is then empty.
_ENGLISH: Final[Mapping[Cause, str]] = {
    Cause.RUNS: "{train} is running.",
    Cause.STOP_LIMIT: "{train} runs slower towards its stop limit before section {section} ({place}){why}.",
    Cause.OUTSIDE: "{train} is not on the line yet; it is due at section {section}{until}.",
    Cause.LEFT: "{unit} has left the line after {train}.",
    Cause.LATE: "{train} comes late to section {section}{until}.",
    Cause.QUEUE: "{train} waits outside section {section} behind another train that is to enter.",
    Cause.PORTAL: "{train} waits outside: a train still stands in section {section}.",
    Cause.DEPARTURE_TIME: "{train} stands {place} until its departure time, {until_at}{why}.",
    Cause.DWELL: "{train} stands {place} for its passengers{until}.",
    Cause.ROUTE_HELD: "{train} waits {place} for its way: section {section} is held by {party}{since}{until}.",
    Cause.NO_WAY_ON: "{train} waits {place} for {party} to come to section {section}: if it went now, not all trains"
    " could still finish.",
    Cause.NOT_ITS_TURN: "{train} waits {place} for {party}, which goes first, to come to section {section}.",
    Cause.REFUSED: "{train} waits {place}: the block manager has refused {asked}{why}.",
    Cause.ANSWER: "{train} waits {place} for the block manager's answer to {asked}{since}{why}.",
    Cause.COVERAGE: "{train} waits {place}: the radio does not reach there, and {asked} cannot be sent.",
    Cause.SET_BACK: "{train} waits {place}: its crew has set back its route and asks for none for a while.",
    Cause.POINTS_MOVE: "{train} waits {place} while points {points} are thrown{since}.",
    Cause.POINTS_REFUSED: "{train} waits {place}: terminal {party} has refused points {points}{why}.",
    Cause.POINTS_PROOF: "{train} waits {place} for terminal {party} to prove points {points}{since}{why}.",
    Cause.POINTS_BY_EYE: "{train} waits {place} on sight until its crew sees points {points} lie as needed.",
    Cause.VEHICLE: "{train} waits {place}: {reason}.",
    Cause.UNABLE: "{train} stays {place}: it could not reach its next stop for want of {reason}.",
    Cause.EMERGENCY: "{train} waits {place} after an emergency stop, which its driver is to acknowledge.",
    Cause.CONTRADICTION: "{train} waits {place}: register and unit contradict each other{why}.",
    Cause.ON_SIGHT: "{train} stands {place} on sight until its crew sees that it can go on: its position is unknown.",
    Cause.UNIT_OFF: "{train} waits {place}: its on-board unit has no power.",
    Cause.UNIT_FROZEN: "{train} waits {place}: its on-board unit does nothing (frozen).",
    Cause.ARRIVAL_BY_EYE: "{train} waits {place} for its driver to confirm that the whole train has arrived.",
    Cause.TURN_BACK: "{train} stands {place} while its driver changes ends for {reason}.",
    Cause.NEXT_TRAIN: "{train} stands {place} while its crew takes up {reason}.",
    Cause.NUMBER: "{train} waits {place} for its crew to enter the train number.",
    Cause.ENTRY: "{train} waits {place} for its crew to take it in: it is signed on.",
    Cause.SIGN_OFF: "{train} waits {place} for its crew to sign off.",
    Cause.LEAVING: "{train} is signed off {place} and is about to leave the line.",
    Cause.STARTING: "{train} is about to start {place}: the way is free and the brakes release.",
    Cause.STABLED: "{unit} is stabled {place} after {train}, its last train.",
}
_JAPANESE: Final[Mapping[Cause, str]] = {
    Cause.RUNS: "{train}は走行中です。",
    Cause.STOP_LIMIT: "{train}は{section}区間手前（{place}）の停止限界点に向けて減速しています{why}。",
    Cause.OUTSIDE: "{train}はまだ線区に入っていません（{until_at}に{section}区間へ進入予定）。",
    Cause.LEFT: "{unit}は{train}の後、線区を出ました。",
    Cause.LATE: "{train}は遅れて{section}区間に到着します{until}。",
    Cause.QUEUE: "{train}は{section}区間の外で先に入る列車の後ろに待っています。",
    Cause.PORTAL: "{train}は線区の外で待っています：{section}区間にまだ列車がいます。",
    Cause.DEPARTURE_TIME: "{train}は{place}で発車時刻{until_at}を待っています{why}。",
    Cause.DWELL: "{train}は{place}で客扱い中です{until}。",
    Cause.ROUTE_HELD: "{train}は{place}で{asked}を待っています：{section}区間を{party}が{since}{until}確保しています。",
    Cause.NO_WAY_ON: "{train}は{place}で{party}が{section}区間に着くのを待っています"
    "：いま出ると全列車が運行を終えられなくなります。",
    Cause.NOT_ITS_TURN: "{train}は{place}で、先に通る{party}が{section}区間に着くのを待っています。",
    Cause.REFUSED: "{train}は{place}で待っています：閉そく管理装置が{asked}を拒否しました{why}。",
    Cause.ANSWER: "{train}は{place}で{asked}に対する閉そく管理装置の応答を待っています{since}{why}。",
    Cause.COVERAGE: "{train}は{place}で待っています：無線エリア外のため{asked}を送信できません。",
    Cause.SET_BACK: "{train}は{place}で待っています：乗務員が進路を取り消し、しばらく要求しません。",
    Cause.POINTS_MOVE: "{train}は{place}で転てつ機{points}の転換を待っています{since}。",
    Cause.POINTS_REFUSED: "{train}は{place}で待っています：端末{party}が転てつ機{points}の制御を拒否しました{why}。",
    Cause.POINTS_PROOF: "{train}は{place}で端末{party}による転てつ機{points}の照査を待っています{since}{why}。",
    Cause.POINTS_BY_EYE: "{train}は{place}で、乗務員が転てつ機{points}の開通を確認できるまで待っています（目視運転）。",
    Cause.VEHICLE: "{train}は{place}で待っています：{reason}。",
    Cause.UNABLE: "{train}は次の停車場まで走れないため{place}で待っています（不足：{reason}）。",
    Cause.EMERGENCY: "{train}は非常停止後、{place}で運転士の確認扱いを待っています。",
    Cause.CONTRADICTION: "{train}は{place}で待っています：管理装置と車上装置の登録が矛盾しています{why}。",
    Cause.ON_SIGHT: "{train}は位置不明のため{place}に停止し、乗務員が進路を確認しています（目視運転）。",
    Cause.UNIT_OFF: "{train}は{place}で待っています：車上装置の電源が切れています。",
    Cause.UNIT_FROZEN: "{train}は{place}で待っています：車上装置が動作を停止しています。",
    Cause.ARRIVAL_BY_EYE: "{train}は{place}で運転士の到着確認を待っています。",
    Cause.TURN_BACK: "{train}は{place}で折返し中です（次は{reason}）。",
    Cause.NEXT_TRAIN: "{train}は{place}で次の列車{reason}に替わるところです。",
    Cause.NUMBER: "{train}は{place}で乗務員による列車番号の入力を待っています。",
    Cause.ENTRY: "{train}は在線登録を終え、{place}で乗務員による進入を待っています。",
    Cause.SIGN_OFF: "{train}は{place}で乗務員による在線抹消の扱いを待っています。",
    Cause.LEAVING: "{train}は在線抹消を終え、{place}から線区を出るところです。",
    Cause.STARTING: "{train}は{place}から発車するところです（進路は開通、ブレーキ緩解中）。",
    Cause.STABLED: "{unit}は最後の列車{train}の後、{place}に留置されています。",
}
_LIMITED_BY: Final[Mapping[str, Phrase]] = {  # causes, where one holds the stop limit back
    Cause.ROUTE_HELD.value: Phrase("held by {party}{since}{until}", "{party}が{since}{until}確保"),
    Cause.NO_WAY_ON.value: Phrase("it waits for {party} to come to its section", "{party}の到着待ち"),
    Cause.NOT_ITS_TURN.value: Phrase("{party} goes first", "{party}が先行"),
    Cause.POINTS_MOVE.value: Phrase("points {points} are being thrown", "転てつ機{points}が転換中"),
    Cause.POINTS_PROOF.value: Phrase("points {points} are not proven", "転てつ機{points}が未照査"),
    Cause.POINTS_REFUSED.value: Phrase("points {points} were refused", "転てつ機{points}の制御が拒否された"),
    Cause.REFUSED.value: Phrase("the block manager has refused its route", "進路が拒否された"),
    Cause.ANSWER.value: Phrase("the block manager has not answered yet", "閉そく管理装置の応答待ち"),
    Cause.COVERAGE.value: Phrase("the radio does not reach there", "無線エリア外"),
    Cause.SET_BACK.value: Phrase("its crew has set back its route", "進路が取り消された"),
}


def at_time(time_s: float) -> str:
    """A time of day as people write it: HH:MM where it is a whole minute, else HH:MM:SS."""
    text = clock(time_s)
    return text.removesuffix(":00")


def text_of(wait: Wait, language: Language, names: Names | None = None) -> str:
    """The wait in one sentence; `names` of stations by id, without which the ids stand in it."""
    sentences = _JAPANESE if language == "ja" else _ENGLISH
    return " ".join(sentences[wait.cause].format(**_parts(wait, language, names or {})).split(" "))


def _parts(wait: Wait, language: Language, names: Names) -> dict[str, str]:
    english = language == "en"
    place = _place(wait, language, names)
    party = f"{wait.party_train} ({wait.party})" if wait.party_train else wait.party or MANAGER_ID
    since = until = ""
    if wait.since_s is not None:
        since = f" since {at_time(wait.since_s)}" if english else f"{at_time(wait.since_s)}から"
    if wait.until_s is not None:
        until = f" until {at_time(wait.until_s)}" if english else f"{at_time(wait.until_s)}まで"
    if wait.cause is Cause.ANSWER and since:
        since = (
            f", asked at {at_time(wait.since_s or 0.0)}"
            if english
            else f"（{at_time(wait.since_s or 0.0)}に要求）"
        )
    elif wait.cause is Cause.OUTSIDE and until:
        until = f" at {at_time(wait.until_s or 0.0)}"
    elif not english and wait.cause is not Cause.ROUTE_HELD and wait.cause is not Cause.STOP_LIMIT:
        since, until = (f"（{text}）" if text else "" for text in (since, until))
    parts = {
        "unit": wait.unit,
        "train": wait.train or wait.unit,
        "place": place,
        "section": wait.section,
        "points": wait.points,
        "party": party,
        "since": since,
        "until": until,
        "until_at": "" if wait.until_s is None else at_time(wait.until_s),
        "asked": _ASKED[wait.asked].in_(language),
        "reason": reason(wait.reason).in_(language),
    }
    return parts | {"why": _why(wait, language, parts)}


def _place(wait: Wait, language: Language, names: Names) -> str:
    english = language == "en"
    if wait.place in names:
        name = names[wait.place].in_(language)
        return f"at {name}" if english else name.removesuffix("駅") + "駅"
    if wait.place:
        return f"at {wait.place}" if english else wait.place
    if wait.at_m is not None:
        where = f"km {wait.at_m / 1000.0:.3f}"
        on = where if english else f"{wait.at_m / 1000.0:.3f} km地点"
        return on if wait.cause is Cause.STOP_LIMIT or not english else f"at {on}"
    return f"outside section {wait.section}" if english else f"{wait.section}区間の外"


def _why(wait: Wait, language: Language, parts: Mapping[str, str]) -> str:
    """The clause that begins where the sentence could end."""
    if wait.reason == "asks again":
        return (
            ", which it repeats: nobody holds it up any more"
            if language == "en"
            else "（支障がなくなり再要求します）"
        )
    if wait.reason == "clock":
        return " by its own clock, which is wrong" if language == "en" else "（車上の時計が狂っています）"
    if wait.reason == "operational":
        return ", without passengers" if language == "en" else "（運転停車）"
    limited = _LIMITED_BY.get(wait.reason)
    said = parts["reason"] if limited is None else limited.in_(language).format(**parts)
    if not said:
        return ""
    return f": {said}" if language == "en" else f"（{said}）"
