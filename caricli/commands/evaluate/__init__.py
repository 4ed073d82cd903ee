"""caricli evaluate."""
