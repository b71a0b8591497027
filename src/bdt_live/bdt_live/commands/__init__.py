"""Subcommands of ``bdt``."""
