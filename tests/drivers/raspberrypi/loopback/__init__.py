"""Tests of the loopback test, on mock lines that wires connect."""
