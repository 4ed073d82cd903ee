"""Processors."""

import os


def usable_cores() -> int:
    """How many this process may use; one where nobody knows."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
