"""Hoverboard mainboards with the FOC firmware."""
