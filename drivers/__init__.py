"""The drivers, one package for each backend.

A driver imports robotcore and its vendor's library, and no other driver.
"""
