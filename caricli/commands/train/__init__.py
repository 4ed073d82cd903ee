"""caricli train."""
