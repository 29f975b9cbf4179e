"""Motors that write their commands into a log, and a cutoff that writes their stop."""
