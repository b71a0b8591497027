"""The numbers of a run: steps, oscillation, estimates, timing."""
