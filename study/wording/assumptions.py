"""What lines and timetables rest on, in Japanese: files hold it in English, in sentences of their makers.

`FORMS` has those of `branchline new line` and of imports, and those of the files that come with the program. A sentence
of a file of somebody's own is shown as it is.
"""

from __future__ import annotations

from typing import Final

from network.model import Line
from study.wording.forms import found
from study.wording.phrase import Phrase

FORMS: Final = (
    # of `new line`
    Phrase(
        "maximum speed: {} km/h, a common figure for branch lines",
        "最高速度：{} km/h（地方線区で一般的な値）",
    ),
    Phrase(
        "limits of curves: the customary basic speeds of 1067 mm gauge, 3.7 sqrt(R) to the nearest 5 km/h",
        "曲線の制限速度：軌間 1067 mm の慣用の本則、3.7√R を 5 km/h 単位に丸め",
    ),
    Phrase(
        "limits of stubs: {} km/h on the last track, towards its end",
        "行止り線の制限速度：終端に向かう番線で {} km/h",
    ),
    Phrase("gradients: level, because no profile was joined", "勾配：縦断面図の資料がないため水平"),
    Phrase("gradients: level where the file has none", "勾配：資料にない区間は水平"),
    Phrase(
        "tracks: {} m or more to either side of a station's place, {} m to the buffers of a stub, for trains of {} m;"
        " how many, and on which side they lie, as the list says, by default 8 m apart about the axis",
        "番線：列車長 {2} m に対し、駅の位置から両側に {0} m 以上、行止り線は車止めまで {1} m。番線数と配置は"
        "駅一覧により、"
        "指定がなければ中心線から 8 m 間隔",
    ),
    Phrase(
        "tracks: {} m or more to either side of a station's place, {} m to the buffers of a stub, for trains of {} m",
        "番線：列車長 {2} m に対し、駅の位置から両側に {0} m 以上、行止り線は車止めまで {1} m",
    ),
    Phrase(
        "points: one behind the other, {} s to throw, {} km/h on the reverse leg (number 12 turnout); normal as the"
        " list says, else for left-hand running",
        "転てつ機：縦列に配置、転換 {} 秒、反位側 {} km/h（12番分岐器）。定位は駅一覧により、指定がなければ左側通行",
    ),
    Phrase(
        "points: one behind the other, {} s to throw, {} km/h on the reverse leg (number 12 turnout); normal for"
        " left-hand running",
        "転てつ機：縦列に配置、転換 {} 秒、反位側 {} km/h（12番分岐器）。定位は左側通行",
    ),
    Phrase(
        "platforms: {} m at stations, {} m at halts, about the station's place; marks that centre the train",
        "ホーム：駅の位置を中心に停車場 {} m、停留所 {} m。停止目標は列車がホームの中央となる位置",
    ),
    Phrase(
        "halts: on the section between stations, where one track is listed: {}",
        "停留所：駅一覧で 1 線の駅は停車場間の区間上に置く：{}",
    ),
    Phrase(
        "portals: {} m of single track beyond {}, for sets from beyond the line",
        "線区端：線区外からの編成のため、{1} の先に単線 {0} m",
    ),
    Phrase(
        "coverage: 1.5 km on either side of each station with tracks of its own, as the paper covers only the"
        " surroundings of stations",
        "無線エリア：文献では停車場付近のみのため、番線をもつ各駅の両側 1.5 km",
    ),
    Phrase("tags: by the rule of network.tag_layout", "地上子：配置規則（network.tag_layout）による"),
    Phrase(
        "room: {} and {} are near each other, so tracks reach {} m and {} m from the middle of the station on the"
        " sides between them, not {} m",
        "余地：{} と {} が近いため、両駅間の側の番線は駅の中心から {} m と {} m（{} m でなく）",
    ),
    Phrase(
        "room: {} m between {} and {} hold no approach tag {} m before points; it lies where the section begins, so a"
        " train that runs through may brake for points that are still thrown",
        "余地：{1} と {2} の間 {0} m には転てつ機の {3} m 手前の接近地上子を置けず、区間の始端に置くため、通過"
        "列車が転換中の"
        "転てつ機に対し減速することがある",
    ),
    Phrase(
        "plan: one straight, because no geometry was joined; so there are no curves and no limits of curves",
        "平面線形：線形の資料がないため一本の直線。曲線も曲線の制限速度もない",
    ),
    Phrase(
        "kilometrage: along the axis fitted to the polyline, from the first station; official kilometrages differ",
        "キロ程：折れ線に当てはめた中心線に沿い、最初の駅から。公式のキロ程とは異なる",
    ),
    Phrase(
        "plan: straights and curves fitted to the polyline, rms {} m, worst {} m at km {}; transitions of 42 m or a"
        " third of the curve, radii in round figures and 200 m at least, because a polyline does not resolve them",
        "平面線形：折れ線に当てはめた直線と曲線（二乗平均誤差 {} m、最大 {} m、{} km 地点）。折れ線からは分か"
        "らないため、"
        "緩和曲線は 42 m または曲線の 3 分の 1、半径は端数を丸めて 200 m 以上",
    ),
    Phrase(
        "cant: equilibrium at the curve's limit for 1067 mm gauge, at most 105 mm and 1/400 of the transition",
        "カント：軌間 1067 mm、曲線の制限速度での均衡カント、105 mm 以下かつ緩和曲線の 400 分の 1 以下",
    ),
    # of imported timetables
    Phrase(
        "dwell: {} s at least, because the source gives whole minutes",
        "停車時分：出典が分単位のため最小 {} 秒",
    ),
    Phrase(
        "times: {} of {} calls have one that is not the source's (marked inferred): an arrival {} s before the"
        " departure, or earlier by {}, but not before {} allows, with starts and stops at {} m/s2; else by distance"
        " between the times around it",
        "時刻：着発 {1} 件中 {0} 件は出典にない時刻。着は発の {2} 秒前、または両方の時刻が"
        "分かる資料から求めた"
        "より早い時刻とし、加減速度 {5} m/s2 で走行可能な時刻より早くしない。ほかは前後の時刻から距離で按分",
    ),
    Phrase("diagrams: {} links between trains are the source's", "運用：列車間の接続 {} 件は出典による"),
    Phrase(
        "diagrams: sets turn back and come back from the portal first in, first out, at least {} outside the line",
        "運用：折返しと線区外からの復帰は先着順、線区外に {} 以上",
    ),
    Phrase("diagrams: sets turn back first in, first out", "運用：折返しは先着順"),
    Phrase(
        "diagrams: sets come back from the portal first in, first out, at least {} outside the line",
        "運用：線区外からの復帰は先着順、線区外に {} 以上",
    ),
    Phrase(
        "turning back takes {} at least, so that {} had another set",
        "折返しには {} 以上かかるため、{} は別の編成とした",
    ),
    Phrase(
        "stabled sets: {} at {} in the morning, {} in the evening, so that the day can not be repeated without a"
        " working that is not published",
        "留置：{1} に朝 {0} 編成、夜 {2} 編成。公表されていない運用がないと翌日に同じ運転を繰り返せない",
    ),
    Phrase(
        "tracks: where sets stand over, the usual one of the direction, or else the first other that is free",
        "番線：停泊する番線はその方向の常用番線、ふさがっていれば最初の空き番線",
    ),
    # of the Karasuyama line
    Phrase(
        "kilometrage: along the fitted axis from Hoshakuji station; the official total of 20.4 km counts from another"
        " zero",
        "キロ程：宝積寺駅を起点に当てはめた中心線に沿う。公式の 20.4 km とは起点が異なる",
    ),
    Phrase(
        "curves: transitions of 42 m (400 times 105 mm) or a third of the curve, radii in round figures and 200 m at"
        " least, because the polyline does not resolve them",
        "曲線：折れ線からは分からないため、緩和曲線は 42 m（105 mm の 400 倍）または曲線の 3 分の 1、半径は端"
        "数を丸めて"
        " 200 m 以上",
    ),
    Phrase(
        "cant: equilibrium at the curve's limit for 1067 mm gauge, at most 105 mm and 1/400 of the transition,"
        " because"
        " it is not published",
        "カント：公表されていないため、軌間 1067 mm、曲線の制限速度での均衡カント、105 mm 以下かつ緩和曲線の 400 "
        "分の 1 以下",
    ),
    Phrase(
        "limits of curves: the customary basic speeds 3.7 sqrt(R) to the nearest 5 km/h; throat of Hoshakuji 45 km/h,"
        " last 200 m into the stub of Karasuyama 30 km/h",
        "曲線の制限速度：慣用の本則 3.7√R を 5 km/h 単位に丸め。宝積寺の分岐部 45 km/h、烏山の行止り線の手前 200 m は"
        " 30 km/h",
    ),
    Phrase(
        "gradients: a smooth profile from the plateau of Hoshakuji (about 148 m) over the hills east of Konoyama to"
        " Karasuyama (about 86 m), level at stations, none over 20 permille, because no profile is published",
        "勾配：縦断面図が公表されていないため、宝積寺の台地（標高約 148 m）から鴻野山東側の丘を越えて烏山（約 86 "
        "m）に至る"
        "滑らかな縦断、駅構内は水平、20‰ 以下",
    ),
    Phrase(
        "points: positions, 6 s to throw, 45 km/h on the reverse leg (number 12 turnout); normal for left-hand"
        " running"
        " at Ogane, for leaving at Hoshakuji",
        "転てつ機：位置、転換 6 秒、反位側 45 km/h（12番分岐器）。定位は大金で左側通行、宝積寺で出発側",
    ),
    Phrase(
        "tracks: lengths, lateral offsets (8 m across the island platform of Ogane) and one Karasuyama line track at"
        " Hoshakuji, with a plain joint at its north end",
        "番線：長さ、左右の間隔（大金の島式ホームをはさみ 8 m）、宝積寺の烏山線用 1 線とその北端の継目",
    ),
    Phrase(
        "portals: straight south of Hoshakuji, entry from the down main and exit to the up main, because the junction"
        " with the main line is outside the line",
        "線区端：本線との接続は対象外のため、宝積寺の南を直線とし、下り本線から進入し上り本線へ進出",
    ),
    Phrase(
        "platforms: 80 m at stations, 65 m at halts, centred on the station's place; marks centre a train of 40 "
        "m (two"
        " cars)",
        "ホーム：駅の位置を中心に停車場 80 m、停留所 65 m。停止目標は 40 m（2 両）の列車が中央となる位置",
    ),
    Phrase(
        "chargers: at Karasuyama the published rigid bar of 1500 V DC for rapid charging, at Hoshakuji the published"
        " stronger wire for normal charging; their powers and the times of the pantograph are assumed",
        "充電設備：烏山は公表の直流 1500 V 剛体架線による急速充電、宝積寺は公表の強化した架線による通常充電。"
        "電力とパンタグラフの動作時間は仮定",
    ),
    Phrase(
        "coverage: about 1.5 km on either side of Hoshakuji, Ogane and Karasuyama, as the paper covers only the"
        " surroundings of stations",
        "無線エリア：文献では停車場付近のみのため、宝積寺・大金・烏山の両側約 1.5 km",
    ),
    Phrase(
        "train E346M (回346M, empty): 345M and 347M both end at Karasuyama, whose one track holds one train, and no"
        " later train leaves it; one set stands there in the morning, so 345M's must go back empty",
        "列車 E346M（回346M、回送）：345M と 347M はともに 1 線 1 列車の烏山止まりで、以後の発車列車がない。朝"
        "の留置は 1 編成"
        "のため、345M の編成は回送で戻る必要がある",
    ),
    # of the Isumi and Kururi lines
    Phrase(
        "tracks: two at Ohara, Kuniyoshi and Otaki, one at Kazusa-Nakano; sets stand at Otaki overnight, on its two"
        " tracks in place of the depot beside them",
        "番線：大原・国吉・大多喜は 2 線、上総中野は 1 線。夜間は隣接する車庫の代わりに大多喜の 2 線に留置",
    ),
    Phrase("sides: trains keep left at Kuniyoshi and Otaki", "通行側：国吉・大多喜は左側通行"),
    Phrase(
        "tracks: two at Kisarazu (one platform in use, sets shunt to the depot beside it) and two at Kazusa-Kameyama,"
        " because sets stand there together; no way on to the main line at Kisarazu",
        "番線：木更津は 2 線（使用ホームは 1 面、編成は隣の車庫へ入換）、上総亀山は編成が同時に留置されるため 2 線。"
        "木更津で本線への接続はない",
    ),
    Phrase(
        "sides: island platforms, trains keep left at Yokota and Kururi",
        "通行側：島式ホーム、横田・久留里は左側通行",
    ),
    # of the test line
    Phrase(
        "all distances: the figures give none; sections 3 to 8 span 690 m so that a 40 m train reaches 45 km/h and"
        " stops",
        "距離：文献の図に記載がないため、40 m の列車が 45 km/h に達して停止できるよう 3～8 区間を 690 m とした",
    ),
    Phrase("line speed 45 km/h: what that length allows", "最高速度 45 km/h：その長さで出せる速度"),
    Phrase(
        "numbering of sections: figure 5 has them numbered in order from the west, track 1 before track 2",
        "区間番号：図 5 のとおり西から順に、1 番線、2 番線の順",
    ),
    Phrase(
        "portals PW and PE: the model's ends, so that sections 1 and 11 lead somewhere",
        "線区端 PW・PE：1・11 区間の先として設けたモデルの端",
    ),
    Phrase(
        "points: 50 m legs, 6 s throw, 25 km/h diverging, as for a small turnout with an electric point machine",
        "転てつ機：分岐側 50 m、転換 6 秒、分岐側 25 km/h（電気転てつ機付きの小形分岐器）",
    ),
    Phrase(
        "points P5 and P7 lie reverse at first: so that the run has to throw both, as the paper's did",
        "転てつ機 P5・P7 は初め反位：文献と同じく両方の転換を要する",
    ),
    Phrase("gradient and curves: level and straight", "勾配・曲線：水平・直線"),
    Phrase(
        "tag (1): where a 40 m train's rear is 12 m clear of the rear points; tag (2): 2 m before the mark",
        "地上子①：40 m の列車の後端が後方の転てつ機から 12 m 離れる位置。地上子②：停止目標の 2 m 手前",
    ),
    Phrase(
        "tag (4): 210 m before the arrival points: 112 m to brake from 45 km/h at 0.7 m/s2 and nearly 8 s to throw",
        "地上子④：到着側転てつ機の 210 m 手前（45 km/h から 0.7 m/s2 の制動で 112 m と、転換の約 8 秒）",
    ),
    Phrase(
        "position tags: 300, 100 and 15 m before each mark",
        "位置補正用地上子：停止目標の 300・100・15 m 手前",
    ),
    Phrase(
        "coverage: the whole test track, which is shorter than the range of its radio",
        "無線エリア：試験線全体（無線の到達距離より短い）",
    ),
    Phrase(
        "times and tracks: the paper gives none; both want the single track between A and B at the same time",
        "時刻・番線：文献に記載がない。両列車が A・B 間の単線を同時に必要とする",
    ),
    Phrase(
        "times: the paper gives none; T3 is due to leave B two minutes after T1 has left the line",
        "時刻：文献に記載がない。T3 は T1 が線区を出た 2 分後に B を発車する",
    ),
    Phrase(
        "times: the paper gives none; 2 minutes hold the throw of the points and a run of about 1 minute",
        "時刻：文献に記載がない。転てつ機の転換と約 1 分の走行に 2 分をとる",
    ),
    Phrase("times: the paper gives none", "時刻：文献に記載がない"),
    Phrase("back to track 2: the usual one of the other direction", "折返し後は 2 番線：反対方向の常用番線"),
    Phrase(
        "times: the paper gives none; T1 stands at B while T3 is due to leave A",
        "時刻：文献に記載がない。T3 が A を発車する時、T1 は B に停車中",
    ),
    Phrase(
        "the second train comes from the west portal and the first one leaves by the east portal: the model's ends",
        "後の列車は西の線区端から進入し、先の列車は東の線区端へ進出する（モデルの端）",
    ),
    # of the busy line
    Phrase(
        "the line: made up by documents.busy_line to measure a busy day; no figure of it has a source",
        "線区：高密度の一日を測るための架空の線区（documents.busy_line）。どの数値にも出典はない",
    ),
    Phrase(
        "stations: six, 6.6 km apart, two tracks of 240 m, platforms of 80 m, marks that centre a train of 40 m",
        "駅：6.6 km 間隔の 6 駅、240 m の 2 線、ホーム 80 m。停止目標は 40 m の列車が中央となる位置",
    ),
    Phrase(
        "maximum speed: 85 km/h, a common figure for branch lines of this class",
        "最高速度：85 km/h（この種の地方線区で一般的な値）",
    ),
    Phrase(
        "plan and profile: a curve of 800 m radius and a rise or fall of 8 permille between any two stations",
        "線形：各駅間に半径 800 m の曲線と 8‰ の上りまたは下り勾配",
    ),
    Phrase(
        "points: 6 s to throw, 45 km/h on the reverse leg, normal for left-hand running",
        "転てつ機：転換 6 秒、反位側 45 km/h、定位は左側通行",
    ),
    Phrase(
        "portals: a depot beyond each end, from which sets come in the morning and to which they go in the evening",
        "線区端：両端の先の車庫から朝に編成が出て、夜に戻る",
    ),
    Phrase(
        "coverage: 1.5 km on either side of each station, as the paper covers only the surroundings of stations",
        "無線エリア：文献では停車場付近のみのため、各駅の両側 1.5 km",
    ),
    Phrase(
        "all times: 7.5 min from station to station, 75 s of them standing, so that trains pass at every station",
        "時刻：各駅で行き違うよう、駅間 7.5 分（うち停車 75 秒）",
    ),
    Phrase(
        "turning back: 975 s at each end, on the track that the set before has left",
        "折返し：両端で 975 秒、前の編成が出た番線を使用",
    ),
    Phrase(
        "all times: six minutes from station to station, as on the busy line; E1 has passed when W2 leaves",
        "時刻：busy_line と同じく駅間 6 分。W2 は E1 の通過後に発車",
    ),
    Phrase(
        "all times: six minutes from station to station, as on the busy line; C has passed EDO when B leaves OKA",
        "時刻：busy_line と同じく駅間 6 分。B は C が EDO を通過した後に OKA を発車",
    ),
    Phrase(
        "all times: six minutes from station to station, as on the busy line",
        "時刻：busy_line と同じく駅間 6 分",
    ),
)


def assumption(text: str, line: Line) -> Phrase:
    """A sentence of a file in both languages, with the names of the line's stations."""
    japanese = {station.name: station.name_ja or station.name for station in line.stations.values()}

    def said(value: str) -> Phrase:
        names = value.replace(" and ", ", ").split(", ")
        return Phrase(value, "、".join(japanese.get(name, name) for name in names).replace(" min", " 分"))

    return found(FORMS, text, said) or Phrase(text)
