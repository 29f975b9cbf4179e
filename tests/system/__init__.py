"""Real kernels and another processor in place of a Raspberry Pi; not part of the test suite, see README.md."""
