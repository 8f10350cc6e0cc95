"""`python -m imubench` is the command line."""

from imubench.cli import main

main()
