"""The procedure, without a screen."""
