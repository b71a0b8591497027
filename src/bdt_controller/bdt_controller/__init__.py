"""Controller: PID with filtered derivative and a switched dead zone."""
