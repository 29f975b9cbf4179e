"""A virtual Raspberry Pi: the same device drivers on virtual pins, connected to a simulator."""
