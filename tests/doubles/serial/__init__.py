"""Boards on a pseudo-terminal that speak the true protocols, with wheels behind."""
