"""Boards that lose their port while they drive: what is plugged in, the app that drives, and what is seen."""
