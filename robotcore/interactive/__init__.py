"""Robots for a prompt or a notebook. `robotcore.open` opens one, and its calls let time pass."""
