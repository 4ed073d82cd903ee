"""Write a page of the heads made of pictures, in the folder that holds them: gallery.py index.html NAME PICTURE...

A head that is not finished is shown as far as it came, with the error of the step that failed.
"""

import html
import json
import sys
from pathlib import Path
from urllib.parse import quote

sys.path.insert(0, str(Path(__file__).parents[1] / "common"))

from page import failure, links, reason, thumbnail, turntable, write_page

SIZE = 1600, 1600  # of a sheet: heads of it stay large enough to see
PICTURE = 1600, 480
STEPS = {"reconstruct": "face.npz", "refine": "refined.npz", "texture": "textured/face.npz", "rig": "rig.glb"}
SHEETS = {"fit": "refined.png", "texture": "textured/sheet.png", "expressions": "rig.png"}
LINKS = {"rig": "rig.glb", "head": "textured/face.glb", "OBJ": "textured/face.obj", "NPZ": "textured/face.npz"}
BODY = """\
<p>{done} of {count} finished. NME: mean distance of landmarks in percent of their bounding box's diagonal. Photometric
error: mean difference between the picture and the textured head in its place, in percent of full scale.</p>
<table>
<tr><th>picture</th><th>NME</th><th>refined</th><th>photometric</th><th></th></tr>
{rows}
</table>
{sections}
"""


def figures(head):
    """What the table says of a head: NME before and after refine, photometric error; percent, empty where unknown."""
    refined, textured = (
        json.loads(path.read_text("utf-8")) if path.is_file() else None
        for path in (head / "refined.json", head / "textured" / "face.json")
    )
    errors = ("", "") if refined is None else (f"{refined['before']['all']:.2f}", f"{refined['after']['all']:.3f}")
    return *errors, "" if textured is None else f"{100 * textured['photometric_error']:.2f}"


def steps(name):
    """The steps of a head for ``failure``."""
    head = Path("heads", name)
    return [(step, head / file, head / "logs" / f"{step}.txt") for step, file in STEPS.items()]


def figure(source, small, size, caption, link=None):
    """A small copy of a picture with its caption; nothing where it cannot be read."""
    shown = thumbnail(source, small, size, caption, link)
    return shown and f"<figure>{shown}<figcaption>{caption}</figcaption></figure>\n"


def section(name, picture):
    """What there is of the head of one picture."""
    head, small = Path("heads", name), Path("thumbnails", name)
    shown = figure(picture, small / "picture.jpg", PICTURE, "picture")
    for caption, file in SHEETS.items():
        shown += figure(head / file, small / f"{caption}.jpg", SIZE, caption, head / file)
    title = f'<h2 id="{quote(name)}">{html.escape(name)}</h2>\n{failure(steps(name))}'
    turning = turntable(head / "rig.glb", small / "rig.js", name)
    return f'{title}{turning}<div class="row">\n{shown}</div>\n<p>{links(head, LINKS)}</p>\n'


def row(name):
    """Its line of the table."""
    cells = "".join(f"<td>{cell}</td>" for cell in figures(Path("heads", name)))
    cells += f'<td class="failed">{html.escape(reason(steps(name)))}</td>'
    return f'<tr><td><a href="#{quote(name)}">{html.escape(name)}</a></td>{cells}</tr>'


def main(page, *given):
    """Write the page of pictures, each given by its name and its path."""
    pictures = dict(zip(given[::2], given[1::2], strict=True))
    done = sum(not reason(steps(name)) for name in pictures)
    rows = "\n".join(row(name) for name in pictures)
    sections = "".join(section(name, picture) for name, picture in pictures.items())
    body = BODY.format(done=done, count=len(pictures), rows=rows, sections=sections)
    write_page(page, "Portraits", body)


if __name__ == "__main__":
    main(*sys.argv[1:])
