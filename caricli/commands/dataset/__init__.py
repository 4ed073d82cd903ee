"""caricli dataset."""
