"""Forms for what a unit's display shows."""
