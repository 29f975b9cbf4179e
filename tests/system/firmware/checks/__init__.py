"""The checks, each on a board of its own."""
