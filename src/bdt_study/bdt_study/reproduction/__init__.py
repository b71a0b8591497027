"""The simulations of the paper again: figures, claims, and how far they survive."""
