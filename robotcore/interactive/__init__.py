"""A robot at a prompt or in a notebook: `open` returns it, and its calls let time pass."""
