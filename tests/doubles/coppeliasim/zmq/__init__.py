"""The ZeroMQ remote API of a simulator: its protocol, and the ``sim`` functions by name."""
