"""The second opinion on energy: what is compared, whose figures they are, what is comparable, what it means."""

from __future__ import annotations

from typing import Final

from study.wording.forms import found
from study.wording.phrase import Phrase

FORMS: Final = (
    Phrase("running resistance of {} at {} km/h", "{} の走行抵抗（{} km/h）"),
    Phrase(
        "1.32 + 0.0164 V + (0.028 + 0.0078 n) V²/W kgf/t, the formula published for JR's electric multiple units",
        "1.32 + 0.0164 V + (0.028 + 0.0078 n) V²/W kgf/t（JR の電車について公表された式）",
    ),
    Phrase(
        "the same train of {} t on straight level track; both are planning formulas, set high",
        "同じ {} t の列車、直線・水平。どちらも余裕をみた計画用の式",
    ),
    Phrase("traction of the day as booked", "一日の力行電力量（計上値）"),
    Phrase(
        "worked out again from the trace of a second with our own resistance",
        "毎秒の走行記録と本結果の走行抵抗から再計算",
    ),
    Phrase(
        "the same day; what differs is the method: powering and coasting within one second, starting resistance",
        "同じ一日。違いは計算法（1 秒内の力行と惰行、出発抵抗）",
    ),
    Phrase("traction of the day on the same speeds", "一日の力行電力量（同じ速度）"),
    Phrase(
        "the same day by the same method: what differs is the running resistance alone",
        "同じ一日、同じ計算法。違いは走行抵抗だけ",
    ),
    Phrase("kWh per car-km", "kWh/車両キロ"),
    Phrase("kWh per train-km", "kWh/列車キロ"),
    Phrase("all electric trains of JR East", "JR東日本の全電車"),
    Phrase("Toyo Keizai online, article 50307", "東洋経済オンライン、記事 50307"),
    Phrase(
        "electricity bought, so with the losses of substations and wires and without what trains regenerate for each"
        " other; long trains, faster and fuller than here; ours is drawn from battery or wire, layovers included",
        "購入電力量のため、変電所・き電線の損失を含み、列車間で融通した回生を含まない。本結果より長編成・高速"
        "・高乗車率。"
        "本結果は蓄電池または架線端、折返しを含む",
    ),
    Phrase("nine private railways round Tokyo", "首都圏の民鉄 9 社"),
    Phrase(
        "livedoor news 16541981, after the railway statistics of fiscal 2016 (about 2)",
        "ライブドアニュース 16541981、2016 年度鉄道統計による（約 2）",
    ),
    Phrase(
        "electricity for running trains as bought, dense commuter traffic; ours as above",
        "購入した運転用電力量、高密度の通勤輸送。本結果は上と同じ",
    ),
    Phrase("the EV-E301 on the flat, less than", "EV-E301 の平坦区間（上限）"),
    Phrase(
        'Sankei, 26 October 2015: "about 50 km on 190 kWh"', "産経新聞 2015年10月26日「190 kWh で約 50 km」"
    ),
    Phrase(
        "a bound: nobody empties a battery, so the train takes less; on the flat, where ours climbs and descen"
        "ds; ours"
        " without layovers",
        "上限値：蓄電池を使い切ることはないため実際はこれより少ない。平坦線（本線区は勾配あり）。本結果は折返"
        "しを含まない",
    ),
)
MORE: Final = Phrase("more", "多い")
LESS: Final = Phrase("less", "少ない")
TRACTION: Final = Phrase(
    "With the train file's resistance the day takes {kwh:,.0f} kWh ({percent:.1f} %) {more} traction than with the"
    " other formula: the day's traction is no more certain than that.",
    "列車ファイルの走行抵抗による一日の力行電力量は、他の式より {kwh:,.0f} kWh（{percent:.1f} %）{more}："
    "力行電力量の確かさはこの程度である。",
)
WITHIN: Final = Phrase(
    "{ours:.2f} kWh per train-km lies within the bound of {theirs:.2f}; a bound shows no more than that.",
    "{ours:.2f} kWh/列車キロは上限 {theirs:.2f} 以内（上限から言えるのはここまで）。",
)
ABOVE_BOUND: Final = Phrase(
    "{ours:.2f} kWh per train-km lies ABOVE the bound of {theirs:.2f}: something is wrong here.",
    "{ours:.2f} kWh/列車キロは上限 {theirs:.2f} を超える：どこかに誤りがある。",
)
BELOW: Final = Phrase("below", "下回る")
ABOVE: Final = Phrase("above", "上回る")
PER_CAR: Final = Phrase(
    "Per car-km we lie {percent:.0f} % {which} {figure}: the order of magnitude agrees; with other trains, spe"
    "eds, loads"
    " and losses no more can be concluded.",
    "車両キロ当たりでは{figure}を {percent:.0f} % {which}：桁は一致する。列車・速度・乗車率・損失が異なり、こ"
    "れ以上は言えない。",
)
NONE: Final = Phrase(
    "A day on which not every train arrived is compared with no published figure.",
    "全列車が到着しなかった日は、公表値と比較しない。",
)


def opinion(text: str) -> Phrase:
    """A text of the table of opinions in both languages."""
    return found(FORMS, text, Phrase) or Phrase(text)
