"""Sweeps: many closed loops over parameters, on all cores or a cluster, and what they tell."""
