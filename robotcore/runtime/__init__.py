"""A run: what is asked for, from opening to closing, the loop that ticks, every way out, and what is told of it."""
