"""Write the page of the workflow's results, in the folder that holds them: gallery.py index.html"""

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "common"))

from plain_page import figure, table, write_page


def errors(report):
    """Errors of networks and fits by what the lines are like."""
    rows = report["millimetres"]
    kinds = list(next(iter(rows.values())))
    lines = [[name, *(f"{row[kind]:.2f}" if kind in row else "" for kind in kinds)] for name, row in rows.items()]
    return table(["faces by", *kinds], lines)


def main(page):
    """Write the page."""
    folder = page.parent
    report = json.loads((folder / "evaluation" / "sketch.json").read_text("utf-8"))
    links = ", ".join(f'<a href="drawn/face.{suffix}">{suffix.upper()}</a>' for suffix in ("obj", "npz", "json"))
    parts = {
        "Errors": errors(report)
        + figure("evaluation/errors.png", "where the errors are")
        + figure("evaluation/strokes.png", "errors as strokes are left out"),
        "Gallery": figure("evaluation/gallery.png", "sketches, what the network makes of them, and the true faces"),
        "A sketch and its face": figure("drawn/lines.png", "lines of somebody who was made up")
        + figure("drawn/face.png", "the face that follows them", f": {links}"),
    }
    faces = report["faces"]
    about = f"{faces} faces of people of no training; mean distances of vertices in mm where the face is 200 mm high."
    write_page(page, "Faces from sketches", about, parts)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
