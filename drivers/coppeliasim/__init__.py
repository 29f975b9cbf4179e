"""The CoppeliaSim backend: a running simulator, stepped over its ZeroMQ remote API."""
