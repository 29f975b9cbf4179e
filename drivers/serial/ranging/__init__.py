"""Range sensors on a line of their own."""
