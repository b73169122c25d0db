"""The documentation's pictures, made by the program: ``python -m solarcal.tui.pictures FOLDER``."""
