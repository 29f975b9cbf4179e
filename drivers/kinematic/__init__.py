"""The built-in simulator ``kinematic``."""
