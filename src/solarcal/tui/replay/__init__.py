"""Saved sessions: replay and recompute."""
