"""Files to begin with: scenarios, timetables, trains and drills that run as they stand."""
