"""Range sensors on a serial line without a motor board."""
