"""Faults, acts and expectations of a drill in words, from what they are: kind, target, figures, events."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Any, Final

from network.clock import clock
from network.files.raw import is_row
from network.model import Position, TagPurpose
from simulation.events import WORLD
from simulation.faults.links import BOTH_WAYS, FaultyLink
from simulation.faults.script import Act, ActKind, Expectation, Matcher, Property, ScriptedFault
from study.wording.event_names import EVENT_NAMES
from study.wording.parties import party
from study.wording.phrase import NOTHING, Phrase, joined
from study.wording.reasons import reason

FAULT_NAMES: Final[Mapping[str, str]] = {
    "power_off": "電源断",
    "lost_store": "電源断（保存データ消失）",
    "restart": "再起動",
    "frozen": "動作停止",
    "clock": "時計の狂い",
    "false_claims": "車上装置の虚偽申告",
    "cut": "通信断",
    "loss": "電文の消失",
    "delay": "伝送の遅れ",
    "duplicate": "電文の重複",
    "reorder": "電文の順序逆転",
    "flip": "電文のビット誤り",
    "dead_zone": "無線の不感地帯",
    "cable_cut": "通信ケーブル切断",
    "scale": "速度発電機の目盛誤差",
    "stuck_output": "速度発電機の出力固着",
    "no_output": "速度発電機の出力なし",
    "slippery": "粘着低下",
    "doors": "戸閉不良",
    "brake": "ブレーキ異常",
    "motors": "主電動機開放",
    "miss": "地上子の検知不能",
    "wrong_id": "地上子の番号誤り",
    "no_beacon": "地点標の検知不能",
    "false_beacon": "地点標の誤検知",
    "gyro_dead": "ジャイロの出力なし",
    "gyro_stuck": "ジャイロの出力固着",
    "gyro_bias": "ジャイロの零点ずれ",
    "gyro_noise": "ジャイロの雑音増大",
    "stuck": "転てつ機の不転換",
    "no_detection": "転てつ機の表示なし",
    "slow": "転てつ機の転換遅れ",
    "charger_dead": "充電設備の停止",
    "gnss_antenna": "GNSSアンテナ故障",
    "gnss_jammed": "GNSS受信妨害",
    "gnss_reflections": "GNSSの反射波",
    "gnss_jump": "GNSS測位の飛び",
    "gnss_time_tag": "GNSS時刻の遅れ",
    "gnss_frozen": "GNSS測位の固着",
    "lidar_blind": "LiDARの遮蔽",
    "lidar_fog": "霧によるLiDARの視程低下",
    "marker_missing": "標識の欠落",
}
FIGURE_NAMES: Final[Mapping[str, str]] = {
    "along_share": "切断位置（割合）{:g}",
    "offset_s": "{:+g} 秒",
    "drift_ppm": "進み {:g} ppm",
    "p": "確率 {:g}",
    "seconds": "{:g} 秒",
    "from_share": "始点（割合）{:g}",
    "length_m": "長さ {:g} m",
    "factor": "{:g} 倍",
    "reserve": "残り {:g}",
    "cut_out": "{:g} 台",
    "bias_m": "{:+g} m",
    "over_m": "{:g} m の間",
    "late_s": "{:g} 秒遅れ",
    "visibility_m": "視程 {:g} m",
    "jump_degps": "{:+g} 度/秒",
    "id": "読取番号 {:g}",
    "section": "{} 区間",
}
ACT_NAMES: Final[Mapping[ActKind, str]] = {
    ActKind.CONFIRM_OUTSIDE: "線区外であることの確認",
    ActKind.TAKE_BACK: "入力の取消",
    ActKind.CONFIRM_HOLDING: "確保区間の手動入力",
    ActKind.ACCEPT_PICTURE: "在線状態の承認",
    ActKind.POWER_ON: "電源投入",
    ActKind.COMMISSION: "使用開始",
    ActKind.REPAIR_POINTS: "転てつ機の手回しと復旧",
    ActKind.ENTER_SECTION: "在線区間の手動入力",
    ActKind.REENTER_BY_HAND: "全区間の手動入力",
    ActKind.REENTER_ASSISTED: "在線状態の確認と承認",
    ActKind.BAR_UNIT: "車上装置の使用停止",
    ActKind.UNBAR_UNIT: "車上装置の使用停止解除",
    ActKind.HAUL_AWAY: "動けない列車の線区外への救援",
    ActKind.GIVE_BACK: "進路取消",
}
_POSITIONS: Final[Mapping[str, str]] = {Position.NORMAL.value: "定位", Position.REVERSE.value: "反位"}
_HOLDS: Final[Mapping[Property, str]] = {
    Property.NO_INVARIANT_BROKEN: "不変条件に違反しない",
    Property.EVERYONE_ARRIVES: "全列車が到着する",
    Property.SPEED_AT_MOST: "{unit}の速度が {kmh:g} km/h 以下",
    Property.NEVER_ENTERS: "{unit}が{section}区間に入らない",
}
LEVELS: Final[Mapping[int, Phrase]] = {
    0: Phrase("ended", "解除"),
    1: Phrase("service brake", "常用ブレーキ"),
    2: Phrase("emergency brake", "非常ブレーキ"),
}
PURPOSES: Final[Mapping[TagPurpose, str]] = {
    TagPurpose.PORTAL: "線区端",
    TagPurpose.APPROACH: "接近",
    TagPurpose.CONTROL_START: "制御開始",
    TagPurpose.POSITION: "位置補正",
    TagPurpose.ARRIVAL: "到着",
    TagPurpose.DEPARTED: "出発",
}
READERS: Final[Mapping[str, Phrase]] = {
    "sign": Phrase("sign", "標識"),
    "gnss": Phrase("gnss", "GNSS"),
    "beacons": Phrase("beacons", "地点標"),
    "curvature": Phrase("curvature", "曲率"),
    "lidar": Phrase("lidar", "LiDAR"),
    "driver's eye": Phrase("driver's eye", "運転士"),
    "nothing": Phrase("nothing", "検知前"),
    "taken": Phrase("taken", "採用"),
    "refused": Phrase("refused", "棄却"),
    "missed": Phrase("missed", "検知なし"),
    "foreign": Phrase("foreign", "異曲率区間"),
}


def fault_text(kind: str, target: object, parameters: Mapping[str, Any]) -> Phrase:
    """A fault with whose it is and its figures."""
    figures = [
        Phrase(
            f"{name} {value}" if isinstance(value, str) else f"{name} {value:g}",
            FIGURE_NAMES.get(name, name + " {}").format(value),
        )
        for name, value in parameters.items()
    ]
    head = Phrase(f"{kind} {target}", f"{FAULT_NAMES.get(kind, kind)}（{_target(target)}）")
    return joined((head, *figures))


def act_text(
    act: str, person: str, target: str, sections: tuple[str, ...] = (), position: str = ""
) -> Phrase:
    """What a person does."""
    english = [f"{person}:" if person else "", act, target, " ".join(sections), position]
    name = ACT_NAMES[ActKind(act)] if act in _ACTS else act
    of = [_target(target) if target else "", "・".join(sections), _POSITIONS.get(position, position)]
    by = f"{party(person).in_('ja')}：" if person else ""
    about = "、".join(filter(None, of))
    return Phrase(" ".join(filter(None, english)), f"{by}{name}" + (f"（{about}）" if about else ""))


def item_text(item: ScriptedFault | Act) -> Phrase:
    """A fault or an act of a script."""
    if isinstance(item, Act):
        return act_text(item.kind.value, item.person, item.target, item.sections, item.position)
    return fault_text(item.fault.kind, item.fault.target, item.fault.parameters())


def expectation_text(expectation: Expectation) -> Phrase:
    """What is expected: in English as its file says it, in Japanese from what is judged."""
    if expectation.event is not None:
        core = f"{matcher_text(expectation.event)}が" + ("ない" if expectation.absent else "ある")
    elif expectation.holds is not None:
        core = _HOLDS[expectation.holds].format(
            unit=expectation.unit, section=expectation.section, kmh=expectation.kmh
        )
        core += "（成立しないこと）" if expectation.absent else ""
    else:
        return Phrase(expectation.text)
    when = [
        "" if expectation.after is None else f"{matcher_text(expectation.after)}の後",
        "" if expectation.within_s is None else f"{expectation.within_s:g} 秒以内",
        "" if expectation.by_s is None else f"{clock(int(expectation.by_s))}まで",
        "" if expectation.until is None else f"{matcher_text(expectation.until)}まで",
    ]
    clause = "、".join(filter(None, when))
    return Phrase(expectation.text, core + (f"［{clause}］" if clause else ""))


def matcher_text(matcher: Matcher) -> str:
    """An event that is waited for, in Japanese."""
    who = (
        f"列車{matcher.train}"
        if matcher.train
        else party(matcher.who).in_("ja")
        if matcher.who and matcher.who != WORLD
        else ""
    )
    name = "・".join(dict.fromkeys(EVENT_NAMES[event].in_("ja") for event in matcher.events))
    values = [value_text(field, value).in_("ja") for field, value in matcher.data.items()]
    about = f"（{'、'.join(filter(None, values))}）" if values else ""
    return (f"{who}の" if who else "") + name + about


def value_text(field: str, value: object) -> Phrase:
    """A field of an event in words."""
    if is_row(value):
        each = [value_text(field, item) for item in value]
        return joined(each, " ", "・")
    if isinstance(value, Enum):
        return value_text(field, value.value)
    if value is None or value == "":
        return NOTHING
    if isinstance(value, float):
        return Phrase(f"{value:g}")
    known = _BY_FIELD.get(field)
    return Phrase(str(value)) if known is None else known(value)


def _target(target: object) -> str:
    if isinstance(target, FaultyLink):
        arrow = "と" if target.both_ways else "から"
        last = "の間" if target.both_ways else "へ"
        return party(target.source).in_("ja") + arrow + party(target.destination).in_("ja") + last
    text = str(target)
    if BOTH_WAYS in text or "->" in text:
        return _target(FaultyLink.parse(text))
    return party(text).in_("ja")


def _kind_of_fault(value: object) -> Phrase:
    return Phrase(str(value), FAULT_NAMES.get(str(value), str(value)))


def _act(value: object) -> Phrase:
    return act_text(str(value), "", "")


def _position(value: object) -> Phrase:
    return Phrase(str(value), _POSITIONS.get(str(value), str(value)))


def _level(value: object) -> Phrase:
    return LEVELS.get(int(str(value)), Phrase(str(value)))


def _purpose(value: object) -> Phrase:
    return Phrase(str(value), PURPOSES[TagPurpose(value)])


def _direction(value: object) -> Phrase:
    return Phrase(str(value), {"down": "下り", "up": "上り"}.get(str(value), str(value)))


def _why(value: object) -> Phrase:
    return Phrase(str(value), reason(str(value)).in_("ja"))


def _reader(value: object) -> Phrase:
    return READERS.get(str(value), Phrase(str(value)))


def _party(value: object) -> Phrase:
    return party(str(value))


_ACTS: Final = frozenset(kind.value for kind in ActKind)
_BY_FIELD: Final = {
    "kind": _kind_of_fault,
    "act": _act,
    "position": _position,
    "lies": _position,
    "level": _level,
    "purpose": _purpose,
    "direction": _direction,
    "why": _why,
    "was": _why,
    "stage": _why,
    "reader": _reader,
    "after": _reader,
    "by": _party,
    "target": _party,
    "source": _party,
    "receiver": _party,
    "device_id": _party,
}
