"""What the line is: stations, tracks, points, sections, tags, gradient, curves, limits, timetables."""
