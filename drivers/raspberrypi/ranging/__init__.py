"""Range sensors: ultrasonic modules on two pins, and time-of-flight chips on I2C."""
