"""The start screen and its profile form."""
