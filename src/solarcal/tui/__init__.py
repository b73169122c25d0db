"""The workstation: screens for the station. Keys become station commands, state becomes widgets."""
