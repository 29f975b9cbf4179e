"""Motors on GPIOs: the drivers of motor boards."""
