"""The command line. `archsim --help` says what there is; everything slow is imported by the verb that needs it."""

import sys


def main() -> None:
    """The entry point of the `archsim` command."""
    try:
        from archsim.cli.app import app

        app()
    except KeyboardInterrupt:  # before the verb has begun
        sys.exit(130)
