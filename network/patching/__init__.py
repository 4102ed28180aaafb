"""A line, or a timetable, as a scenario changes it: tables set, tracks and loops added or taken out."""
