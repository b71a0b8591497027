"""Checks of the repository that no tool from an index does; ``make check`` runs them."""
