"""Kinds of devices that robotcore does not have, each the file of a package of its own."""
