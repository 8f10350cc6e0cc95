"""What a dataset says about itself to those who get it: README.md with its card, croissant.json, units of columns."""
