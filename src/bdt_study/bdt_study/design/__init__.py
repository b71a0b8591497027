"""Linear analysis and the design of the PID."""
