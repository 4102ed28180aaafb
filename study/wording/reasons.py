"""Why something was refused, stopped or doubted: the journal's own words (`why`) as people say them.

The words are those of enums and constants of who writes them; what stands after a colon is whose or what it is about.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from study.wording.forms import found
from study.wording.parties import party
from study.wording.phrase import Phrase, joined
from study.wording.telegrams import TELEGRAMS

REASONS: Final[Mapping[str, Phrase]] = {
    "": Phrase("", ""),
    "no power": Phrase("it has no power", "電源が切れています"),
    "frozen": Phrase("it does nothing (frozen)", "動作を停止しています"),
    "cable cut": Phrase("the cable to the centre is cut", "センターへの通信ケーブルが切断されています"),
    "undefined": Phrase(
        "the block manager does not yet know what every unit holds", "在線状態が復元されておらず未定義です"
    ),
    "unknown route": Phrase("there is no such route", "そのような進路がありません"),
    "unknown section": Phrase("there is no such section", "そのような閉そく区間がありません"),
    "not connected": Phrase(
        "the train does not hold the section before the route", "手前の区間を確保していません"
    ),
    "not signed on": Phrase("the unit has not signed on since its restart", "在線登録がされていません"),
    "still holding": Phrase(
        "the train holds more than the portal", "入出区間のほかにも閉そくを確保しています"
    ),
    "stale token": Phrase("the unit's token is not the newest", "トークンが最新ではありません"),
    "claim needed": Phrase("a person must say what the train holds", "確保区間を人が入力する必要があります"),
    "wrong unit": Phrase("the unit named is not the sender", "送信した装置と名乗りが一致しません"),
    "unknown points": Phrase("the terminal has no such points", "その転てつ機は端末にありません"),
    "wrong section": Phrase("the points lie in another section", "転てつ機は別の区間にあります"),
    "bad capability": Phrase("the terminal cannot verify the grant", "その確保は端末で確認できません"),
    "old token": Phrase("a newer holder has commanded since", "後の確保者がすでに制御しました"),
    "locked": Phrase("the points are locked in the other position", "反対側に鎖錠されています"),
    "not detected": Phrase(
        "position or lock was not detected in time", "時間内に転換・鎖錠が確認できませんでした"
    ),
    "locked by hand": Phrase("a crew has locked the points by hand", "乗務員が現地で鎖錠しています"),
    "doors not closed": Phrase("its doors are not shown as closed", "扉の閉が確認できません"),
    "brake not in order": Phrase("its brake is not in order", "ブレーキに異常があります"),
    "the register has less": Phrase(
        "the register has less than the train holds", "管理装置の登録が列車の確保より少なくなっています"
    ),
    # of the block manager and its people
    "held": Phrase("another unit holds a section asked for", "他の列車が確保しています"),
    "unknown token": Phrase("the token was never granted", "交付されていないトークンです"),
    "no way on": Phrase("not every train could finish its day", "全列車が運行を終えられなくなります"),
    "not its turn": Phrase("another train goes first", "先に通る列車があります"),
    "barred": Phrase("the unit is barred", "車上装置が使用停止です"),
    "not on the fleet list": Phrase("not on the fleet list", "登録車両にありません"),
    "no name": Phrase("the entry has no name", "操作者の名がありません"),
    "too early": Phrase("too early after the restart", "再起動直後のため受け付けません"),
    "it is so already": Phrase("it is so already", "すでにその状態です"),
    "a second person must say the same": Phrase(
        "a second person must enter the same", "別の人の同じ入力が必要です"
    ),
    "it may be on the line; a second person must say the same": Phrase(
        "it may be on the line; a second person must enter the same",
        "線区内にいる可能性があり、別の人の同じ入力が必要です",
    ),
    "a silent unit must stand in a station": Phrase(
        "a silent unit must stand in a station", "応答のない車上装置は停車場に停止していなければなりません"
    ),
    "the unit is still being asked; say it again if it stays silent": Phrase(
        "the unit is being asked; enter it again if it does not answer",
        "車上装置に照会中です。応答がなければ再度入力してください",
    ),
    "it speaks for itself: no word counts": Phrase(
        "the unit reports itself: no person's entry counts", "車上装置自身が報告しており、人の入力は無効です"
    ),
    "it has said so itself": Phrase("the unit has reported so itself", "車上装置自身がそう報告しています"),
    "no word of a person counts for it": Phrase(
        "no person's entry counts for it", "人の入力の対象ではありません"
    ),
    "nothing to restore": Phrase("nothing to restore", "復元するものがありません"),
    "say by which portal it left the line": Phrase(
        "enter by which portal it left the line", "どの入出区間から出たかの入力が必要です"
    ),
    "an empty entry; confirm the unit as outside": Phrase(
        "an empty entry; confirm the unit as outside", "空の入力です。線区外であることを確認してください"
    ),
    "an empty report; sign off to leave the line": Phrase(
        "an empty report; sign off to leave the line", "空の報告です。線区を出るには在線抹消が必要です"
    ),
    "entered by hand, says it is outside": Phrase(
        "entered by hand, says it is outside", "手動入力では在線、車上装置は線区外と報告しています"
    ),
    "a token that was never granted": Phrase(
        "a token that was never granted", "交付されていないトークンです"
    ),
    "a train has left by this portal, and its holder may be elsewhere": Phrase(
        "a train has left by this portal, and its holder may be elsewhere",
        "列車がこの入出区間から出ましたが、確保している列車は別の場所にいる可能性があります",
    ),
    "it may have been on the line, and says that it is outside": Phrase(
        "it may have been on the line, and says that it is outside",
        "線区内にいた可能性があるのに線区外と報告しています",
    ),
    "it counts as outside, and signs on without knowing what it holds": Phrase(
        "it counts as outside, and signs on without knowing what it holds",
        "線区外のはずの車上装置が、確保区間不明のまま在線登録しました",
    ),
    "two units claim it": Phrase("two units claim it", "二つの車上装置が確保を主張しています"),
    "entered for one unit, claimed by another": Phrase(
        "entered for one unit, claimed by another", "手動入力と異なる車上装置が確保を主張しています"
    ),
    "two persons entered it differently": Phrase(
        "two persons entered it differently", "二人の入力が一致しません"
    ),
    "entered for a unit that says it is outside": Phrase(
        "entered for a unit that says it is outside", "線区外と報告した車上装置の区間として入力されています"
    ),
    "entered as free, claimed: added": Phrase(
        "entered as free, claimed: added", "空きと入力された区間の確保が主張され、追加しました"
    ),
    "entered, but its unit does not claim it: added": Phrase(
        "entered, but its unit does not claim it: added",
        "入力された区間を車上装置は主張していませんが、追加しました",
    ),
    "unknown": Phrase("unknown", "状態不明"),
    "outside": Phrase("outside", "線区外"),
    "by hand": Phrase("by hand", "手動入力"),
    "reported": Phrase("reported", "報告済み"),
    "leaving": Phrase("leaving", "進出中"),
    "disputed": Phrase("disputed", "矛盾"),
    "incomplete": Phrase("incomplete", "復元中"),
    "complete": Phrase("complete", "承認待ち"),
    "accepted": Phrase("accepted", "承認済み"),
    "defined": Phrase("defined", "復元完了"),
    "not complete": Phrase("not complete", "未完了"),
    "claim refused": Phrase("its claim was refused", "確保の主張が拒否されました"),
    "found in what it does not hold": Phrase(
        "found in what it does not hold", "確保していない区間での位置検知"
    ),
    "contested": Phrase("contested", "矛盾している区間"),
    # of terminals
    "lost": Phrase("the proof was lost", "照査が失われました"),
    "not detected in time": Phrase("not detected in time", "時間内に転換・鎖錠が確認できませんでした"),
    # of units
    "points not proven": Phrase("points not proven", "転てつ機未照査"),
    "not held": Phrase("the section is not held", "進路未確保"),
    "to be passed on sight": Phrase("to be passed on sight", "目視運転で通過する区間"),
    "end of the path": Phrase("end of the path", "経路の終端"),
    "no mission": Phrase("no train taken up", "運行なし"),
    "possible": Phrase("possible", "可能"),
    "brake too weak": Phrase("the brake is too weak", "ブレーキ力不足"),
    "target not seen": Phrase(
        "no beacon or sign where one was due", "地点検知なし（標識・地上子を検知できず）"
    ),
    "sign beyond limit": Phrase("the mark lies beyond the stop limit", "停止目標が停止限界より先にあります"),
    "the bounds leave no room to go on": Phrase(
        "the bounds leave no room to go on", "位置の誤差範囲のため進む余地がありません"
    ),
    "a tag was passed while the tachometer shows a stand": Phrase(
        "a tag was passed while the tachometer shows a stand",
        "速度発電機が停止を示す間に地上子を通過しました",
    ),
    "the tachometer shows what cannot be": Phrase(
        "the tachometer shows what cannot be", "速度発電機の出力があり得ない値です"
    ),
    "fixes miss the bounds of the position": Phrase(
        "fixes miss the bounds of the position", "位置検知の結果が位置の誤差範囲に入りません"
    ),
    "expected tag was not read": Phrase("an expected tag was not read", "予定の地上子を検知できません"),
    # of telegrams
    "corrupted": Phrase("corrupted", "伝送誤り"),
    "wrong destination": Phrase("wrong destination", "宛先違い"),
    "unknown source": Phrase("unknown source", "送信元不明"),
    "meant for an earlier boot": Phrase("meant for an earlier boot", "再起動前の装置宛て"),
    "old epoch": Phrase("of an earlier boot", "再起動前の送信"),
    "implausible time": Phrase("implausible time", "時刻が不合理"),
    "stale": Phrase("stale", "有効時間超過"),
    "repeated": Phrase("repeated", "重複"),
    "out of order": Phrase("out of order", "順序逆転"),
}
# What the journal says with a name or a number in it.
_WITH_NAMES: Final = (
    Phrase("tag {} where none can be", "そこにないはずの地上子{}を検知しました"),
    Phrase("section {} is held by {}", "{}区間は{}が確保しています"),
    Phrase("entered by {}", "{}の入力"),
    Phrase("the unit is {}", "車上装置の状態は{}です"),
    Phrase("section {} of {}", "{}区間、{}"),
    Phrase("section {}", "{}区間"),
    Phrase("unit {}", "車上装置{}"),
)


def reason(why: str) -> Phrase:
    """A `why` of the journal, in words; as it is where it has no other."""
    known = REASONS.get(_word(why))
    if known is not None:
        return known
    named = found(_WITH_NAMES, why, _said)
    if named is not None:
        return named
    head, colon, rest = why.partition(":")
    if colon:
        of, about = _said(head), _said(rest)
        return Phrase(f"{of.en} ({about.en})", f"{of.in_('ja')}（{about.in_('ja')}）")
    if "," in why:
        return joined(map(_said, why.split(",")))
    return TELEGRAMS.get(why) or party(why)


def _said(part: str) -> Phrase:
    return reason(part.strip())


def _word(why: str) -> str:
    return why.strip().lower().replace("_", " ")
