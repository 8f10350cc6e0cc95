"""What the commands do and print, a module each; imported when a command runs, so that help comes at once."""
