"""What a comparison of runs says: figures, headings and sentences. English words are the keys of the figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from study.wording.phrase import Language, Phrase

NOT_LATE: Final = Phrase("not late (within {most})", "遅れなし（{most}以内）")
AT_MOST: Final = Phrase("at most {most} late", "遅れ {most}以内")
HEADING: Final = Phrase("{what}: old", "{what}：旧")
AT_STATION: Final = Phrase("{train} at {place}", "{train} {place}")
LATER: Final = Phrase("{by_s:.1f} s later", "{by_s:.1f} 秒遅く")
EARLIER: Final = Phrase("{by_s:.1f} s earlier", "{by_s:.1f} 秒早く")
DID_NOT_RUN: Final = Phrase("{trains} did not run in the {which} run", "{trains} は{which}の走行にない")
AND: Final = Phrase(" and ", "と")

CHANGED: Final = Phrase("What changed against {label}", "{label} からの変化")
DIFFERENCES: Final = Phrase(
    "{count} differences, after the patches of both runs.", "{count} 件（両走行の変更指定を反映）"
)
ONE_DIFFERENCE: Final = Phrase(
    "1 difference, after the patches of both runs.", "1 件（両走行の変更指定を反映）"
)
ROWS: Final = Phrase("{count} rows", "{count} 行")
# the verdict
NOTHING_AT_ALL: Final = Phrase(
    "Nothing differs at all, {inputs}: the journals of both runs are the same.",
    "{inputs}、両走行の記録は同一で、相違は全くない。",
)
SAME_INPUTS: Final = Phrase("from the same inputs", "入力が同じで")
OTHER_INPUTS: Final = Phrase("though the inputs differ", "入力は異なるが")
ONLY_IN: Final = Phrase("Only in {where}: {trains}.", "{where} だけの列車：{trains}。")
TRAINS: Final = Phrase("trains {shown}", "{shown}")
ONE_TRAIN: Final = Phrase("train {shown}", "{shown}")
MORE_TRAINS: Final = Phrase("trains {shown} and {rest} more", "{shown} ほか {rest} 本")
CAME_ONCE: Final = Phrase(
    "{count} of trains in both runs are in one run only.",
    "両走行に共通の列車の着発のうち {count}は、一方の走行だけにある。",
)
BROKEN_ONLY: Final = Phrase("Broken only in {where}: {texts}.", "{where} だけの違反：{texts}。")
NONE_COMPARED: Final = Phrase(
    "No arrival or departure is in both runs: there is nothing to compare.",
    "両走行に共通の着発がなく、比較できない。",
)
NOTHING_MOVED: Final = Phrase(
    "Nothing moved by more than {over}: {both} compared, {largest}.",
    "{over}を超えて変わった着発はない：{both}を比較、{largest}。",
)
MOVED: Final = Phrase(
    "{count} of {both} moved by more than {over}, {later} later and {earlier} earlier, of {trains}; {largest}.",
    "{both}のうち {count} 件が{over}を超えて変化（遅く {later} 件、早く {earlier} 件、列車 {trains}）。{largest}。",
)
BOTH: Final = Phrase("{count} arrivals and departures", "着発 {count} 件")
LARGEST: Final = Phrase("the largest difference is {largest_s:.1f} s", "最大の差は {largest_s:.1f} 秒")
SECONDS: Final = Phrase("{over_s:g} s", "{over_s:g} 秒")
NO_MEET: Final = Phrase("No meet moved.", "行違いの変化なし。")
MEETS: Final = Phrase("{count} changed: {each}.", "行違い {count} 件が変化：{each}。")
_SPANS: Final = (5, 15, 60, 180, 300)
_JAPANESE: Final[Mapping[str, str]] = {
    # groups of figures
    "trains": "列車",
    "arrivals": "到着",
    "departures": "出発",
    "margins": "余裕時分",
    "energy": "電力量",
    "driving": "運転",
    "telegrams": "電文",
    "stops at the mark": "停止位置",
    "events": "事象",
    "safety": "安全",
    # figures
    "planned": "計画",
    "ran their whole journey": "全区間を走行",
    "meets as run": "行違い（実績）",
    "never came": "未着・未発",
    "mean lateness": "平均遅延",
    "worst lateness": "最大遅延",
    "smallest planned": "計画の最小",
    "least left as run": "実績の残りの最小",
    "mean left as run": "実績の残りの平均",
    "hops that the plan cannot keep": "計画が成立しない駅間",
    "traction": "力行",
    "auxiliary": "補機",
    "regenerated": "回生",
    "net": "正味",
    "net, with layovers": "正味（折返しを含む）",
    "of it standing": "うち停車中",
    "of it layovers": "うち折返し停留",
    "regenerated, of traction": "回生率（力行に対する）",
    "distance": "走行距離",
    "volume": "通信量",
    "measured": "測定回数",
    "mean error": "平均誤差",
    "sigma of error": "誤差の標準偏差",
    "largest error": "最大誤差",
    "interventions": "保安ブレーキの介入",
    "refusals": "拒否",
    "faults": "故障",
    "invariants broken": "不変条件の違反",
    "collisions": "衝突",
    # units
    "s": "秒",
    "train-km": "列車キロ",
    "kWh/train-km": "kWh/列車キロ",
    "kWh/car-km": "kWh/車両キロ",
    # headings
    "difference": "差",
    "file": "ファイル",
    "key": "キー",
    "old": "旧",
    "new": "新",
    "set by": "設定元",
    "train": "列車",
    "station": "駅",
    "what": "着発",
    "moved": "変化",
    "by plan": "うち計画",
    "only in": "走行",
    "at": "時刻",
    "meet": "変化の種類",
    "by": "差",
    # values
    "down": "下り",
    "up": "上り",
    "arrival": "着",
    "departure": "発",
    "passing": "通過",
    "elsewhere": "場所",
    "another time": "時刻",
    "gone": "消滅",
    "base": "比較元",
    "command line": "コマンドライン",
    "scenario": "シナリオ",
    "learned": "学習結果",
}


def span(seconds: int) -> Phrase:
    """So many seconds, as people say it."""
    return (
        Phrase(f"{seconds} s", f"{seconds} 秒")
        if seconds < 60
        else Phrase(f"{seconds // 60} min", f"{seconds // 60} 分")
    )


WORDS: Final[Mapping[str, str]] = dict(_JAPANESE) | {
    said.en: said.ja
    for seconds in _SPANS
    for said in (NOT_LATE.of(most=span(seconds)), AT_MOST.of(most=span(seconds)))
}


def word(text: str, language: Language) -> str:
    """A figure's name, unit or heading in a language; ids and labels as they are."""
    return WORDS.get(text, text) if language == "ja" else text


def phrase(text: str) -> Phrase:
    """The same in both languages."""
    return Phrase(text, WORDS.get(text, ""))
