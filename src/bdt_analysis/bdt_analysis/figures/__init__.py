"""Figures of runs: their looks, curves and honest decimation."""
