"""A loop in the browser: the mechanism moving, running plots, sliders for the parameters."""
