"""Where a timetable's reserves (余裕時分) lie, on runs, at stops and at meets: placed against late days."""
