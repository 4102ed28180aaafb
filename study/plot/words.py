"""The words of pictures in Japanese: every text of a figure that is known is put into the language chosen."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from matplotlib.figure import Figure
from matplotlib.text import Text

from study.record.energy import SpentByTrain
from study.record.figure import figures_of
from study.record.wait import Cause
from study.report.stairway import SHOWN_AS
from study.wording.phrase import Language

JAPANESE: Final[Mapping[str, str]] = {
    **{said.name.en: said.name.ja for said in figures_of(SpentByTrain).values()},
    **{part.value: japanese for part, (_, japanese) in SHOWN_AS.items()},
    # headways and occupation
    "occupancy time rate, %; the thin line is the limit recommended by UIC 406": "占有率 [%]（細線：推奨上限）",
    "cut: whole": "区切り方：全線",
    "cut: crossing": "区切り方：交換駅間",
    "cut: interval": "区切り方：駅間と駅",
    "cut: section": "区切り方：閉そく区間ごと",
    # a drill on the train graph
    "while a fault lasts": "故障の時間",
    "its stretch of the line": "故障の区間",
    "the train that has it": "故障した列車",
    "a person acts": "人の操作",
    # axes and legends of the figures that the report has too
    "kilometrage, km": "キロ程 [km]",
    "speed, km/h": "速度 [km/h]",
    "speed": "速度",
    "target": "目標速度",
    "speed limit of the line": "線区の制限速度",
    "permitted by supervision": "照査速度",
    "supervision brakes": "保安ブレーキ",
    "gradient\n‰": "勾配\n‰",
    "curve\nradius m": "曲線半径\nm",
    "notch": "ノッチ",
    "energy, kWh": "電力量 [kWh]",
    "auxiliary, running": "補機（走行中）",
    "auxiliary, standing": "補機（停車中）",
    "stops": "停車回数",
    "front beyond the mark, m": "停止位置の誤差（停止目標から） [m]",
    "held": "確保",  # on the graph of sections, and not before a stop limit
    "occupied": "在線",
    "down trains": "下り列車",
    "up trains": "上り列車",
    "down": "下り",
    "up": "上り",
    "running time, s": "運転時分 [s]",
    "planned": "計画",
    "planned, too short": "計画（不足）",
    "needed, from stand to stand": "所要（停車～停車）",
    "needed, passing both": "所要（通過～通過）",
    # this package's own
    "m, ahead of the truth": "真の位置より前 [m]",
    "within its bounds": "位置の範囲",
    "position unknown, on sight": "位置不明（最徐行）",
    "believed less true": "誤差（推定−真値）",
    "fixes again, or by the driver's eye": "位置補正（再開・運転士）",
    "fix refused": "補正を棄却",
    "fix missed": "検知なし",
    "foreign track: not what the map has": "異曲率区間",
    "position found": "位置確定",
    "position lost": "位置検知異常",
    "as run": "実績",
    "arrival": "着",
    "departure": "発",
    "share on time (less than 1 min late), %": "定時率（遅れ1分未満） [%]",
    "lateness, s": "遅れ [s]",
    "mean ± σ": "平均±σ",
    "95th percentile": "95パーセンタイル",
    "worst": "最大",
    "hour": "時",
    "state of charge": "充電状態",
    "reserve to be kept": "留保分",
    "nothing to use below": "使用下限",
    "charges": "充電",
    "off the line": "線外",
    "time": "時刻",
    "net energy, kWh": "正味電力量 [kWh]",
    "per train, kWh": "1列車あたり [kWh]",
    "margin, s": "余裕時分 [s]",
    "left on arrival, as run": "到着時の残り（実績）",
    "running": "走行",
    "at a stop": "停車",
    "stabled": "留置",
    "passes": "通過",
    "trains": "列車",
    "empty": "回送",
    "conflict": "競合",
    "The plan is in whole minutes: less than one minute says little.": (
        "計画は分単位のため、1分未満の値はあまり意味を持ちません。"
    ),
}
CAUSES: Final[Mapping[Cause, str]] = {
    Cause.RUNS: "走行",
    Cause.STOP_LIMIT: "停止限界による減速",
    Cause.OUTSIDE: "線区外（進入前）",
    Cause.LATE: "遅れて進入",
    Cause.LEFT: "線区外（進出後）",
    Cause.QUEUE: "進入順番待ち",
    Cause.PORTAL: "進入口支障",
    Cause.DEPARTURE_TIME: "発車時刻待ち",
    Cause.DWELL: "客扱い",
    Cause.ROUTE_HELD: "進路支障",
    Cause.NO_WAY_ON: "先行進路なし",
    Cause.NOT_ITS_TURN: "順序待ち",
    Cause.REFUSED: "要求拒否",
    Cause.ANSWER: "応答待ち",
    Cause.COVERAGE: "無線エリア外",
    Cause.SET_BACK: "進路取消",
    Cause.POINTS_MOVE: "転てつ機転換",
    Cause.POINTS_REFUSED: "転てつ機制御拒否",
    Cause.POINTS_PROOF: "転てつ機照査待ち",
    Cause.POINTS_BY_EYE: "転てつ機現地確認",
    Cause.VEHICLE: "車両異常",
    Cause.UNABLE: "走行不能",
    Cause.EMERGENCY: "非常停止確認待ち",
    Cause.CONTRADICTION: "登録矛盾",
    Cause.ON_SIGHT: "目視運転",
    Cause.UNIT_OFF: "車上装置断",
    Cause.UNIT_FROZEN: "車上装置停止",
    Cause.ARRIVAL_BY_EYE: "到着確認待ち",
    Cause.TURN_BACK: "折返し",
    Cause.NEXT_TRAIN: "次列車へ",
    Cause.NUMBER: "列番入力待ち",
    Cause.ENTRY: "進入",
    Cause.SIGN_OFF: "在線抹消扱い",
    Cause.LEAVING: "進出",
    Cause.STARTING: "発車",
    Cause.STABLED: "留置",
}
_PATTERNS: Final = (
    (
        re.compile(r"(.+): least headway, s \(columns behind rows\)"),
        r"\1：最小運転時隔 [s]（行が先行、列が続行）",
    ),
    (re.compile(r" day: (\d+) %, (\d+) trains, (.+)"), r" 終日 \1 %、\2本、\3"),
    (re.compile(r" peak: (\d+) %, (\d+) trains, (.+)"), r" ピーク \1 %、\2本、\3"),
    (re.compile(r" chosen: (\d+) %, (\d+) trains, (.+)"), r" 指定時間帯 \1 %、\2本、\3"),
    (re.compile(r"(.+): (−?[\d.]+) kWh, (\d+) s"), r"\1：\2 kWh、\3秒"),
    (re.compile(r"(\d+) power,\n(\d+) brake"), r"力行 \1回\n制動 \2回"),
    (re.compile(r"mean ([+−-][\d.]+) m"), r"平均 \1 m"),
    (re.compile(r"mean ± σ, σ = ([\d.]+) m"), r"平均±σ、σ = \1 m"),
    (
        re.compile(r"(.+), (down|up): minimum running times and what the timetable plans"),
        r"\1 \2：基準運転時分と計画",
    ),
    (re.compile(r"(.+)\ncharge, %"), r"\1\n充電率 [%]"),
    (re.compile(r"(.+): (\d+) %, (-?\d+) kWh left to use"), r"\1：\2 %、残り \3 kWh"),
    (re.compile(r"off the line\n(.+)"), r"線外\n\1"),
)


def cause_name(cause: Cause, language: Language) -> str:
    """A cause in few words."""
    return CAUSES[cause] if language == "ja" else cause.value


def word(text: str, language: Language) -> str:
    """A text of a figure in a language; as it is where it has no other."""
    if language == "en":
        return text
    known = JAPANESE.get(text)
    if known is not None:
        return known
    for pattern, replacement in _PATTERNS:
        if pattern.fullmatch(text):
            translated = pattern.sub(replacement, text)
            return translated.replace(" down：", " 下り：").replace(" up：", " 上り：")
    return text


def translate(figure: Figure, language: Language) -> None:
    """Put every known text of a figure into a language."""
    for text in figure.findobj(Text):
        said = word(text.get_text(), language)
        if said != text.get_text():
            text.set_text(said)
