"""Looks of the figures and honest decimation."""
