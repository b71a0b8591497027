"""Limit cycles of the linear controller, predicted and simulated."""
