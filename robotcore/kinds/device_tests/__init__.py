"""Tests of devices that need more than a few lines. A kind refers to its own as `Kind.test_devices`."""
