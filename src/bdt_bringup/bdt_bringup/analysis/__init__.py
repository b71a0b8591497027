"""What a run was like: numbers for each step, figures, report."""
