"""Whole bags from what a crash, a full disk or a power cut has left."""
