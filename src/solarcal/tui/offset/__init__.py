"""Set Sun Offset."""
