"""How much a line carries: blocking times, headway, capacity (閉そく占有時分, 時隔, 線路容量)."""
