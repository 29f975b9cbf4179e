"""Sabertooth motor boards in packet serial mode, which take frames of four bytes and send nothing."""
