"""Drive on a serial port: a framed protocol, and the class that speaks it."""
