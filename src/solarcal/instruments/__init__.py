"""The field calculators, each declared once: the command and the form are both made from it."""
