"""Lines and timetables from other people's formats."""
