"""A controller without a line: a person reads its display, and types.

``forms`` are what is asked, ``typo_hints`` what is noticed at once, ``unit`` the ``Tracker`` made
of the answers, ``field_book`` the answers of a whole calibration in a file.
"""
