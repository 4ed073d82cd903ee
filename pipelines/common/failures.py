"""What the pages of workflows share: what failed."""

import html


def failure(steps):
    """A line that says what failed, or nothing; see ``reason``."""
    said = reason(steps)
    return said and f'<p class="failed">{html.escape(said)}</p>\n'


def reason(steps):
    """What failed, or did not come to its end, or nothing.

    steps: (name, file, log) in their order. What comes before one that is done was not needed, if it is not there.
    """
    steps = list(steps)
    done = max((k + 1 for k, step in enumerate(steps) if step[1].is_file()), default=0)
    if done == len(steps):
        return ""
    name, _, log = next((step for step in steps[done:] if step[2].is_file()), steps[done])
    lines = log.read_text("utf-8", "replace").splitlines() if log.is_file() else []
    said = next((line for line in reversed(lines) if "error" in line), None)
    return f"{name} did not finish" if said is None else f"{name} failed: {said}"
