"""Solvers that do not do what they should, as processes: `ODD_SOLVER` says which."""

import os
import sys

for _ in sys.stdin.buffer:
    if os.environ["ODD_SOLVER"] == "nonsense":
        sys.stdout.write("{]\n")
        sys.stdout.flush()
    elif os.environ["ODD_SOLVER"] == "ends":
        sys.exit(0)
