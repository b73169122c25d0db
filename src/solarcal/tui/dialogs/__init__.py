"""Dialogs of the procedure."""
