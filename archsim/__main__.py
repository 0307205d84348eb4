"""`python -m archsim`: the same as the command `archsim`."""

from archsim.cli import main

main()
