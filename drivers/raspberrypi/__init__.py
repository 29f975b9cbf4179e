"""The real robot: a Raspberry Pi, with motors, sensors and cameras on its pins, buses and ports."""
