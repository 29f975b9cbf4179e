"""Tests on real kernels, an emulated processor and real simulators; not part of the test suite, see README.md."""
