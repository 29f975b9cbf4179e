"""Hoverboard mainboards with the FOC firmware: frames of 8 and 18 bytes."""
