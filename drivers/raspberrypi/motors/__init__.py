"""Motors on pins: the drivers of motor boards, and their output lines."""
