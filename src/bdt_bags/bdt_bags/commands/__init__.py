"""Subcommands of ``bdt`` about bags."""
