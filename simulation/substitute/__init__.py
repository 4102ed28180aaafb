"""People who work a line whose block manager is off: trains driven by hand, operators, pilots (代用閉そく)."""
