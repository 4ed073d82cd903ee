"""Sheets: pictures with several views, before and after, and what a user looks at."""
