"""Bags of the loop: reading, writing, recovery, and the recorder node."""
