"""caricli template."""
