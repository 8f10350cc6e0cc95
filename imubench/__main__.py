"""`python -m imubench` is the command line."""

from imubench.main import main

main()
