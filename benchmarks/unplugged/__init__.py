"""Boards that lose their port while they drive, and the app that drives them."""
