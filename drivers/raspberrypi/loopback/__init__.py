"""The loopback test of `robotcore doctor`: a Pi measures itself over two wires between its own pins."""
