"""Everything that can contradict a fit: functions from records to findings, one module a kind."""
