"""Tests that send SIGINT need children that heed it, also where the tests themselves run in the background."""

import signal

# A shell starts background commands with SIGINT ignored, and ignoring is inherited; a handler is not.
signal.signal(signal.SIGINT, signal.default_int_handler)
