"""The workstation's screen and panes."""
