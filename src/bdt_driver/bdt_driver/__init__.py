"""Driver: a real drive, screw and sensor in place of the plant simulator."""
