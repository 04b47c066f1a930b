"""`python -m app` is the `relight` command, and so is `main`, which the installed command calls."""

import sys


def main() -> int:
    """Run the command line; returns its exit code, also where it is interrupted before it has been read."""
    try:
        from app.endings import raise_no_more, take_endings_for_interrupts

        take_endings_for_interrupts()
        from app.cli.main import main as run

        return run(interrupted=raise_no_more)
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
