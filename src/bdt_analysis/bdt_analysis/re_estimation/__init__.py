"""The gap estimated again from a recording, with any estimator and settings."""
