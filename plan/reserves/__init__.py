"""Where a timetable's reserves (余裕時分) lie: on running times, at stops and at meets, placed against sampled late days."""
