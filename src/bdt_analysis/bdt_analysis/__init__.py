"""Numbers, figures and pages of runs of the loop."""
