"""`robotcore doctor`: what is right and wrong with this machine and its backends."""
