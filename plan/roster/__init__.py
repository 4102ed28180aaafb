"""As few sets as can run a timetable's trains (運用), and why fewer cannot."""
