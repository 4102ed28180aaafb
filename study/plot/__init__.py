"""Pictures and tables of a finished run, one kind at a time: PNG, SVG and CSV."""
