"""Gains and dead-zone rule for a mechanism that is known within ranges: ``bdt tune``."""
