"""The edge of the program: what went wrong becomes lines on stderr and an exit code."""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Callable
from typing import Any

import typer

from archsim.errors import ArchsimError

FAILED_CHECK, BAD_INPUT, INTERRUPTED = 1, 2, 130


def at_the_edge(command: Callable[..., None]) -> Callable[..., None]:
    """`command`, with bad input ending in one line per problem and exit code 2, Ctrl-C in exit code 130."""

    @functools.wraps(command)
    def guarded(*args: Any, **kwargs: Any) -> None:
        try:
            command(*args, **kwargs)
            sys.stdout.flush()
        except ArchsimError as error:
            for problem in error.problems:
                print(problem, file=sys.stderr)
            raise typer.Exit(BAD_INPUT) from None
        except KeyboardInterrupt:
            print("interrupted", file=sys.stderr)
            raise typer.Exit(INTERRUPTED) from None
        except BrokenPipeError:  # the reader, such as `head`, has seen enough
            _mute_stdout()
        except OSError as error:  # a full disk, a device that is gone
            _mute_stdout()
            print(f"{error.filename or 'cannot write'}: {error.strerror or error}", file=sys.stderr)
            raise typer.Exit(BAD_INPUT) from None

    return guarded


def _mute_stdout() -> None:
    """What is still in the buffer has nowhere to go; without this, Python would complain about it at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
