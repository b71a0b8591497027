"""Plant: DC motor, lead screw with growing backlash, flexible three-mass structure."""
