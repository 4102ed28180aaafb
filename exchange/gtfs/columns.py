"""Columns of our own in GTFS tables, which other readers pass over: what GTFS has no words for.

With them a timetable that was written is read again as the same: which calls are passed, which times and tracks were
given, how a train begins and ends.
"""

from __future__ import annotations

from typing import Final

CALL: Final = "branchline_call"  # of stop_times: stop, operational or pass
TIMES: Final = "branchline_times"  # of stop_times: arrival, departure or both, as planned
TRACK: Final = "branchline_track"  # of stop_times: the track that is named; empty: the usual one
REVENUE: Final = "branchline_revenue"  # of trips: 0 for an empty working
BEGINS: Final = "branchline_begins"  # of trips, as timetable files write it
ENDS: Final = "branchline_ends"  # of trips, as timetable files write it
TIMETABLE: Final = "branchline_timetable"  # of feed_info: head and diagrams of the timetable file, JSON

NO_PASSENGERS: Final = "1"  # of pickup_type and drop_off_type: none get on (off)
INFERRED: Final = "0"  # of timepoint: times are approximate
