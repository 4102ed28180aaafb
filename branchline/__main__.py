"""Entry point of `branchline` and `python -m branchline`: looks for files that hide its packages, then runs."""

from __future__ import annotations

import gc
import sys
from typing import Final

from branchline.hidden import hidden_package

COLLECTED_AFTER: Final = (
    20_000  # objects that live on; after Python's 700, imports alone are looked through again and again
)


def main() -> None:
    """Run the command line. A file in the place of one of the packages is one line and exit code 2."""
    gc.set_threshold(COLLECTED_AFTER, 20, 20)
    if (hidden := hidden_package()) is not None:
        sys.stderr.write(f"error: {hidden}\n")
        sys.exit(2)
    from branchline.cli import main as run_command_line

    run_command_line()


if __name__ == "__main__":
    main()
