"""What a run leaves behind on disk, read and written: its directory, its tables, what its report shows."""
