"""Files about lines: their schema, reading, patching, and finding those that are shipped."""
