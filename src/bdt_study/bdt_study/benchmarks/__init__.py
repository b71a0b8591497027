"""Measurements beside a peer and a floor."""
