"""Nonsense at every door of the program: only ``SolarcalError`` comes out, with a place.

``make fuzz`` is a million cases; ``tests/fuzzing`` a few thousand of the same.
"""
