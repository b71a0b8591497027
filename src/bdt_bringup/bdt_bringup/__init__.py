"""Entry point of the backlash digital twin: the command ``bdt`` in place of a launch file."""
