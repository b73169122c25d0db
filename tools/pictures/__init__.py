"""The documentation's pictures, made by the program: ``python -m tools.pictures FOLDER``."""
