"""The recorder node: what it takes and how its bag describes it."""
