"""What the tests let worker processes do."""

import os
import time
from pathlib import Path

from archsim.errors import fail


def double(number, progress):
    progress(f"doubling {number}", 1, 1)
    return 2 * number


def wrong(name, progress):
    raise fail(f"{name} is wrong", hint="try another")


def die(progress):
    os._exit(7)


def sleep(folder, progress):
    Path(folder, str(os.getpid())).touch()
    time.sleep(60)
