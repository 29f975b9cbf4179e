"""Doubles of boards on a pseudo-terminal, with the real protocols and with wheels."""
