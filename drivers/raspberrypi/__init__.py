"""The real robot: motors, sensors and cameras on the pins, buses and ports of a Raspberry Pi."""
