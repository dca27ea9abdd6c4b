"""What every claim of the validation shares: running abbe, judging by standard error, planting errors, figures, the report."""
