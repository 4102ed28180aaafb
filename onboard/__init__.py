"""What the train decides: localisation, authority, supervision, driving, stopping at the mark, the unit."""
