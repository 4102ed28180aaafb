"""Entry point of `branchline` and `python -m branchline`: looks for files that hide its packages, then runs."""

from __future__ import annotations

import sys

from branchline.hidden import hidden_package


def main() -> None:
    """Run the command line. A file in the place of one of the packages is one line and exit code 2."""
    if (hidden := hidden_package()) is not None:
        sys.stderr.write(f"error: {hidden}\n")
        sys.exit(2)
    from study.runner.collector import collecting_rarely

    with collecting_rarely():
        from branchline.cli import main as run_command_line

        run_command_line()


if __name__ == "__main__":
    main()
