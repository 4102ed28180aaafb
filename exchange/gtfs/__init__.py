"""GTFS (gtfs.org, schedule): tables read with caps, service days, a feed as a published timetable, and back."""
