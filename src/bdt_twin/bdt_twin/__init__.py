"""Digital twin: estimates the backlash gap and reconfigures the controller's dead zone."""
