"""A virtual Raspberry Pi: the device drivers of the real one on virtual pins, connected to a simulator."""
