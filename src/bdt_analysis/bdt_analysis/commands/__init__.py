"""Subcommands of ``bdt`` that look at what was recorded."""
