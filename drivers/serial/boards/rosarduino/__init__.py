"""Arduinos with ROSArduinoBridge, or with robotcore_bridge, the firmware of this project with the same protocol."""
