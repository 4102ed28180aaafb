"""What a run came to in words: rules broken, dangers, what is missing, how it ended, what a drill's verdict says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from simulation.events import Danger, Unsafe
from simulation.judge.checkers import Checker, Violation
from simulation.result import Ending
from study.wording.phrase import Phrase

CHECKERS: Final[Mapping[Checker, str]] = {
    Checker.ONE_TRAIN_A_SECTION: "一つの閉そく区間に複数の列車",
    Checker.NO_DOUBLE_GRANT: "閉そくの二重確保",
    Checker.INSIDE_HOLDING: "確保していない区間への進入",
    Checker.POINTS_UNDER_TRAIN: "列車の下の転てつ機が未鎖錠または別方向",
    Checker.NO_THROW_UNDER_TRAIN: "列車の下で転てつ機が転換",
    Checker.PROVEN_BEFORE_ENTRY: "未照査の転てつ機への進入",
    Checker.RELEASE_BEHIND_REAR: "列車のいる区間の解放",
    Checker.UNDEFINED_GRANTS_NOTHING: "在線状態が未定義のままの確保",
    Checker.WITHIN_BOUNDS: "真の位置が誤差範囲の外",
    Checker.TELEGRAM_ONCE: "同じ電文の二重の受付",
    Checker.SUMO_COLLISION: "列車どうしの衝突",
    Checker.EVERYONE_ARRIVES: "列車の未着",
    Checker.TOKENS_GROW: "トークンが増加していない",
    Checker.NO_JUMP: "列車の位置の飛び",
    Checker.NO_DEAD_STATE: "待つものがないまま停止",
}
DANGERS: Final[Mapping[Danger, str]] = {
    Danger.CANNOT_TURN: "が番線を行き過ぎ、折返し不能",
    Danger.END_OF_TRACK: "が線路の終端を越えた",
    Danger.PANTOGRAPH_UP: "がパンタグラフを上げたまま動いた",
    Danger.NO_POSITION: "が開通していない転てつ機 {points} に進入",
    Danger.WRONG_WAY: "が転てつ機 {points} で別方向へ進んだ",
    Danger.SET_AGAINST: "が転てつ機 {points} を割り出した",
}
ENDINGS: Final[Mapping[Ending, str]] = {
    Ending.FINISHED: "全列車が運行を終えた",
    Ending.TIME_LIMIT: "走行の制限時間",
    Ending.STALLED: "どの列車も動けなくなった",
    Ending.COLLISION: "衝突",
    Ending.END_OF_TRACK: "列車が線路の終端を越えた",
    Ending.CANNOT_TURN: "列車が番線を行き過ぎ、折返し不能",
}
MISSING: Final = Phrase("{count} trains did not arrive: {trains}", "{count} 本が未着：{trains}")
NOT_HOME: Final = Phrase(
    "{unit} has not left the line and does not stand where its last duty ends",
    "{unit} が線区を出ず、最後の運用の終着にもいない",
)
ON_ITS_WAY: Final = Phrase(
    "{train} ({unit}) was on its way in {place}", "{train}（{unit}）は {place} を走行中だった"
)
STANDS: Final = Phrase(
    "{train} ({unit}) stands in {place} and waits for {what}",
    "{train}（{unit}）は {place} に停止（待ち：{what}）",
)
DANGER: Final = Phrase("{unit} {how}", "{unit}{how}")
CUT_SHORT: Final = Phrase("the run was cut short: {why}", "走行を打ち切った：{why}")
SLIPPERY: Final = Phrase(
    "{unit} had less adhesion than the design assumes {times} from {since} to {until}, at least {least:.2f} of the"
    " dry rail's",
    "{unit} の粘着が設計値を下回った（{times}、{since}～{until}、最小は乾燥時の {least:.2f} 倍）",
)
ONCE: Final = Phrase("once", "1 回")
TIMES: Final = Phrase("{count} times", "{count} 回")
THE_END: Final = Phrase("the end", "終了")
RULE: Final = Phrase("{checker}: {text}", "{checker}：{text}")
OUTSIDE: Final = Phrase("{at} {what}", "{at} {what}")
ALL_ARRIVED: Final = Phrase("all arrived", "全列車到着")
NONE_BROKEN: Final = Phrase("none broken", "違反なし")
OUTSIDE_DESIGN: Final = Phrase("outside the design: {what}", "設計の範囲外：{what}")
OUTSIDE_LINE: Final = Phrase("Outside the design: {what}", "設計の範囲外：{what}")
EXPECTED: Final = Phrase("Expected: {what}", "期待：{what}")
# of an event, or of a stretch of time
DID_NOT: Final = Phrase("did not happen", "起きなかった")
HAPPENED: Final = Phrase("happened at {at}", "{at} に起きた")
AT: Final = Phrase("at {at}", "{at}")
NEVER: Final = Phrase("never happened", "一度も起きなかった")
TOO_LATE: Final = Phrase("happened at {at}, outside the time given", "{at} に起きたが、定めた時間の外")
NO_STRETCH: Final = Phrase("'{what}' never happened", "「{what}」が起きなかった")
BACKWARDS: Final = Phrase(
    "the time given ends at {at}, before it begins", "定めた時間が始まる前の {at} に終わる"
)
STOOD: Final = Phrase("stood all the time", "終始停止")
AT_MOST: Final = Phrase("at most {kmh:.1f} km/h", "最高 {kmh:.1f} km/h")
NOT_ENTERED: Final = Phrase("did not enter", "進入なし")
ENTERED: Final = Phrase("entered at {at}", "{at} に進入")
# of what was drawn for a late day, by the table that it comes from
DRAWN: Final[Mapping[str, str]] = {
    "entry": "列車{who}が線区端 {place} に {seconds:.0f} 秒遅れて到着",
    "dwell": "列車{who}の停車が {place} で {seconds:.0f} 秒延びる",
    "doors": "列車{who}の戸閉が {place} で {seconds:.0f} 秒遅れる",
    "dead_zones": "{place} 区間が無線の不感地帯となる（{seconds:.0f} 秒）",
    "failures": "{who} の故障（復旧まで {seconds:.0f} 秒）",
}
# of a fault, and of the scores
LASTS: Final = Phrase("lasts", "継続")
AT_ONCE: Final = Phrase("at once", "瞬時")
NO_TRAIN: Final = Phrase("No train arrived.", "到着列車なし。")
LATEST: Final = Phrase("Latest {late_s:.0f} s after plan.", "最大遅延 {late_s:.0f} 秒。")
NO_NORMAL: Final = Phrase("No time back to normal, because {why}.", "平常復帰なし（{why}）。")
NORMAL: Final = Phrase(
    "Back to normal {normal_s:.0f} s after the last repair at {healed}: from then on every departure was within"
    " {tolerance_s:.0f} s of plan.",
    "最後の復旧（{healed}）の {normal_s:.0f} 秒後に平常復帰：以後の発車はすべて計画から {tolerance_s:.0f} 秒以内。",
)
NOTHING_DISTURBED: Final = Phrase("nothing was disturbed", "乱れなし")
FAULT_LASTS: Final = Phrase("a fault lasts to the end", "故障が終了まで継続")
SOME_MISSING: Final = Phrase("not every train arrived", "未着の列車あり")
PASSED: Final = Phrase("passed: {count} met", "合格：{count} 件成立")
FAILED: Final = Phrase(
    "NOT passed: {count} of {all} expectations not met", "不合格：期待 {all} 件中 {count} 件不成立"
)
MET: Final = Phrase("met", "成立")
NOT_MET: Final = Phrase("NOT MET", "不成立")
VERDICT: Final = Phrase("{met}: {text}: {happened}", "{met}：{text}：{happened}")
UNMET: Final = Phrase("{text}: {happened}", "{text}：{happened}")


def violation_text(violation: Violation) -> Phrase:
    """A broken rule without its name's colon: in Japanese the rule itself and whom it is about."""
    return Phrase(violation.text, violation.subject or violation.text)


def rule_text(violation: Violation) -> Phrase:
    """A broken rule by its name, and how."""
    return RULE.of(checker=checker_name(violation.checker), text=violation_text(violation))


def checker_name(checker: str) -> Phrase:
    """A checker, or what else is outside the design."""
    known = next((name for rule, name in CHECKERS.items() if rule.value == checker), "")
    return Phrase(checker, "危険な事象" if checker == "unsafe" else known)


def unsafe_text(event: Unsafe) -> Phrase:
    """What happened to a train that must never happen, without whose it is."""
    return Phrase(event.text, DANGERS[event.danger].format(points=event.points_id))


def ending_text(ending: str) -> Phrase:
    """Why a run ended."""
    return Phrase(ending, next((words for known, words in ENDINGS.items() if known.value == ending), ""))
