"""The commands, one module each: its options, its help, and what it says; `imubench.cli` lists them."""
