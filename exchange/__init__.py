"""What others publish, read and written: timetables, layouts, geometry; and a whole line from a list of stations."""
