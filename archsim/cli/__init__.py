"""The command line. `archsim --help` says what there is; everything slow is imported by the verb that needs it."""


def main() -> None:
    """The entry point of the `archsim` command."""
    from archsim.cli.app import app

    app()
