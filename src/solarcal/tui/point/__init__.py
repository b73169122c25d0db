"""Take, open and judge data points."""
