"""Write a page of the heads made of pictures, in the folder that holds them: gallery.py index.html NAME PICTURE...

A head that is not finished is shown as far as it came, with the error of the step that failed.
"""

import html
import json
import sys
from pathlib import Path
from urllib.parse import quote

from PIL import Image

HEIGHT = 360
STEPS = {"reconstruct": "face.npz", "refine": "refined.npz", "texture": "textured/face.npz", "rig": "rig.glb"}
SHEETS = {"fit": "refined.png", "texture": "textured/sheet.png", "expressions": "rig.png"}
LINKS = {"rig": "rig.glb", "head": "textured/face.glb", "OBJ": "textured/face.obj", "NPZ": "textured/face.npz"}
PAGE = """\
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Portraits</title>
<style>
  body {{ margin: 2rem auto; padding: 0 1rem; max-width: 100rem; font: 1rem/1.5 system-ui, sans-serif; color: #222 }}
  .row {{ display: flex; flex-wrap: wrap; gap: 1rem }}
  figure {{ margin: 0 }}
  figure img {{ max-width: 100%; border: 1px solid #ddd }}
  figcaption {{ color: #666 }}
  table {{ border-collapse: collapse }}
  th, td {{ padding: 0.2rem 0.8rem; border-bottom: 1px solid #ddd; text-align: right }}
  th:first-child, td:first-child {{ text-align: left }}
  .failed {{ color: #b00 }}
</style>
<h1>Portraits</h1>
<p>{done} of {count} finished. NME: mean distance of landmarks in percent of their bounding box's diagonal. Photometric
error: mean difference between the picture and the textured head in its place, in percent of full scale.</p>
<table>
<tr><th>picture</th><th>NME</th><th>refined</th><th>photometric</th></tr>
{rows}
</table>
{sections}
</html>
"""


def figures(head):
    """What the table says of a head: NME before and after refine, photometric error; percent, empty where unknown."""
    refined, textured = (
        json.loads(path.read_text("utf-8")) if path.is_file() else None
        for path in (head / "refined.json", head / "textured" / "face.json")
    )
    errors = ("", "") if refined is None else (f"{refined['before']['all']:.2f}", f"{refined['after']['all']:.3f}")
    return *errors, "" if textured is None else f"{100 * textured['photometric_error']:.2f}"


def failure(head):
    """A line that says what failed, or did not come to its end, or nothing."""
    step = next((step for step, file in STEPS.items() if not (head / file).is_file()), None)
    if step is None:
        return ""
    log = head / "logs" / f"{step}.txt"
    lines = log.read_text("utf-8", "replace").splitlines() if log.is_file() else []
    said = next((line for line in reversed(lines) if "error" in line), None)
    said = f"{step} did not finish" if said is None else f"{step} failed: {said}"
    return f'<p class="failed">{html.escape(said)}</p>\n'


def figure(source, small, caption, link=None):
    """A small copy of a picture, with a link to the whole one if there is one; nothing where it cannot be read."""
    try:
        with Image.open(source) as picture:
            picture = picture.convert("RGB")
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError):
        return ""
    picture.thumbnail((3 * HEIGHT, HEIGHT))
    small.parent.mkdir(parents=True, exist_ok=True)
    picture.save(small, quality=85)
    shown = f'<img src="{quote(small.as_posix())}" alt="{caption}" width="{picture.width}" height="{picture.height}">'
    shown = f'<a href="{quote(link.as_posix())}">{shown}</a>' if link else shown
    return f"<figure>{shown}<figcaption>{caption}</figcaption></figure>\n"


def section(name, picture):
    """What there is of the head of one picture."""
    head, small = Path("heads", name), Path("thumbnails", name)
    shown = figure(picture, small / "picture.jpg", "picture")
    for caption, file in SHEETS.items():
        shown += figure(head / file, small / f"{caption}.jpg", caption, head / file)
    links = [f'<a href="{quote(str(head / f))}">{k}</a>' for k, f in LINKS.items() if (head / f).is_file()]
    title = f'<h2 id="{quote(name)}">{html.escape(name)}</h2>\n{failure(head)}'
    return f'{title}<div class="row">\n{shown}</div>\n<p>{", ".join(links)}</p>\n'


def row(name):
    """Its line of the table."""
    cells = "".join(f"<td>{cell}</td>" for cell in figures(Path("heads", name)))
    return f'<tr><td><a href="#{quote(name)}">{html.escape(name)}</a></td>{cells}</tr>'


def main(page, *given):
    """Write the page of pictures, each given by its name and its path."""
    pictures = dict(zip(given[::2], given[1::2], strict=True))
    done = sum(not failure(Path("heads", name)) for name in pictures)
    rows = "\n".join(row(name) for name in pictures)
    sections = "".join(section(name, picture) for name, picture in pictures.items())
    Path(page).write_text(PAGE.format(done=done, count=len(pictures), rows=rows, sections=sections), "utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
