"""The CoppeliaSim backend: a running simulator, driven step by step over its ZeroMQ remote API."""
