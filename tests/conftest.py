"""Tests that send SIGINT need children that heed it, also where the tests themselves run in the background; and tests
of compiled code may take as long as a compiler does.
"""

import signal

from hypothesis import settings

# A shell starts background commands with SIGINT ignored, and ignoring is inherited; a handler is not.
signal.signal(signal.SIGINT, signal.default_int_handler)

# The first example compiles, the others do not: a deadline would fail on that, and on a busy machine.
settings.register_profile("compiled", settings.default, deadline=None)
settings.load_profile("compiled")
