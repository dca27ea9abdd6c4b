"""What every claim of the validation shares: running abbe, judging by standard error, figures, the report."""
