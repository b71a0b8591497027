"""Subcommands of ``bdt`` that start something."""
