"""The CoppeliaSim backend, which drives a running CoppeliaSim in lockstep over its ZeroMQ remote API."""
