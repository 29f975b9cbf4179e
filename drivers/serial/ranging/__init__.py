"""Range sensors with their own serial line."""
