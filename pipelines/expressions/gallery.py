"""Write a page of drawings with expressions, in the folder that holds them.

gallery.py index.html DRIVER PICTURE... / NAME PICTURE..., where a PICTURE may be empty. What is not finished is shown
as far as it came, with the error of the step that failed.
"""

import html
import json
import sys
from pathlib import Path

from caricli.io.page import PageFolder, SmallCopy

sys.path.insert(0, str(Path(__file__).parents[1] / "common"))

from failures import failure

HERE = PageFolder()
SIZE = 384, 384  # as large as `retarget` draws them
# Pictures in the first row of the sheets of blendshapes, retarget and fit-morphable.
BLENDSHAPES, RETARGET, FIT = 9, 2, 5
STEPS = {
    "detect": "landmarks.json",
    "reconstruct": "face.npz",
    "refine": "refined.npz",
    "texture": "textured/face.npz",
    "blendshapes": "blendshapes.npz",
}
LINKS = {
    "all expressions": "blendshapes.png",
    "film": "film.mp4",
    "GLB": "blendshapes.glb",
    "NPZ": "blendshapes.npz",
    "JSON": "blendshapes.json",
}
BODY = """\
<p>{done} of {count} expressions finished. The first column is the drawing, the second its head, the third the same at
rest; then the head does what the faces of the first row do. A click on a picture shows the driving face as it was
understood.</p>
<table class="tiles">
<tr><th></th><th>as drawn</th><th>neutral</th>{drivers}</tr>
{rows}
</table>
"""


def driver_failure(driver):
    """A line that says why a driver could not be drawn, or nothing."""
    return failure([("driver", Path("drivers", f"{driver}.png"), Path("drivers", "logs", f"{driver}.txt"))])


def head_failure(name, picture):
    """A line that says what failed before the expressions of a head, or nothing."""
    head = Path("heads", name)
    steps = {step: file for step, file in STEPS.items() if picture or step != "texture"}
    return failure((step, head / file, head / "logs" / f"{step}.txt") for step, file in steps.items())


def driver_cell(driver, picture, names):
    """The head of a column: the face that drives it; of landmarks without a picture, the one that `retarget` found."""
    drawn = Path("drivers", f"{driver}.png")
    source, cell = drawn, None
    if drawn.with_suffix(".obj").is_file():
        found = (Path("heads", name, "expressions", f"{driver}.png") for name in names)
        sheet = None if picture else next(filter(Path.is_file, found), None)
        source, cell = (sheet, (RETARGET, 0)) if sheet else (drawn, (FIT, 0))
    shown = HERE.thumbnail(SmallCopy(source, Path("drivers", f"{driver}.jpg"), SIZE, cell), driver, drawn)
    return f"<th>{html.escape(driver)}{driver_failure(driver)}{shown}</th>"


def head_cells(name, picture):
    """The drawing, and the head with and without its own expression."""
    head, small = Path("heads", name), Path("heads", name)
    source, cell = (Path(picture), None) if picture else (head / "face.png", (FIT, 0))
    drawing = HERE.thumbnail(SmallCopy(source, small / "drawing.jpg", SIZE, cell), "drawing")
    title = f"<b>{html.escape(name)}</b>{head_failure(name, picture)}"
    turning = HERE.turntable(head / "blendshapes.glb", small / "blendshapes.js", name)
    cells, sheet = [f"{title}{drawing}{turning}{HERE.links(head, LINKS)}"], head / "blendshapes.png"
    figures = sheet.with_suffix(".json")
    shown = 1 + len(json.loads(figures.read_text("utf-8"))["expressions"]) if figures.is_file() else BLENDSHAPES
    for k, caption in enumerate(("as drawn", "neutral")):
        cell = min(shown, BLENDSHAPES), k
        cells.append(HERE.thumbnail(SmallCopy(sheet, small / f"{caption}.jpg", SIZE, cell), caption, sheet))
    return cells


def expression_cell(name, picture, driver):
    """A head with the expression of a driver."""
    faces = Path("heads", name, "expressions")
    sheet, small = faces / f"{driver}.png", Path("heads", name, "expressions", f"{driver}.jpg")
    shown = HERE.thumbnail(SmallCopy(sheet, small, SIZE, (RETARGET, 1)), driver, sheet)
    if not (shown or head_failure(name, picture) or driver_failure(driver)):
        shown = failure([("retarget", sheet, faces / "logs" / f"{driver}.txt")])
    files = {kind.upper(): f"{driver}.{kind}" for kind in ("obj", "npz", "json")}
    return shown + HERE.links(faces, files)


def main(page, *given):
    """Write the page of drivers and drawings, each given by its name and its picture."""
    middle = given.index("/")
    drivers, drawings = (
        dict(zip(part[::2], part[1::2], strict=True)) for part in (given[:middle], given[middle + 1 :])
    )
    rows = []
    for name, picture in drawings.items():
        cells = head_cells(name, picture) + [expression_cell(name, picture, driver) for driver in drivers]
        rows.append("<tr>" + "".join(f"<td>{cell}</td>\n" for cell in cells) + "</tr>")
    done = sum(Path("heads", name, "expressions", f"{driver}.obj").is_file() for name in drawings for driver in drivers)
    heads, rows = "".join(driver_cell(*driver, drawings) for driver in drivers.items()), "\n".join(rows)
    body = BODY.format(done=done, count=len(drawings) * len(drivers), drivers=heads, rows=rows)
    HERE.write(Path(page), "Expressions", body)


if __name__ == "__main__":
    main(*sys.argv[1:])
