"""What a dataset must be before anything is trained on it: one look at its columns, and a few of its pictures."""
