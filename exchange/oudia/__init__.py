"""Timetables of OuDia (.oud) and OuDiaSecond (.oud2), the train graph editors that Japanese timetables are drawn in."""
