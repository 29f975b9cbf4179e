"""The checks, each on its own board."""
