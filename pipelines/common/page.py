"""What the pages of workflows share: small copies of pictures, heads to turn, and what failed."""

import base64
import gzip
import html
import json
import shutil
from pathlib import Path
from urllib.parse import quote

from PIL import Image

COMMON = Path(__file__).parent
VIEWER = Path("thumbnails", "viewer")  # copied beside every page, so that it can be moved and needs no network
GAP = 0.03  # between the pictures of caricli's sheets, of their side
PAGE = """\
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
  body {{ margin: 2rem auto; padding: 0 1rem; max-width: 100rem; font: 1rem/1.5 system-ui, sans-serif; color: #222 }}
  .row {{ display: flex; flex-wrap: wrap; gap: 1rem }}
  figure {{ margin: 0 }}
  figure img {{ max-width: 100%; border: 1px solid #ddd }}
  figcaption {{ color: #666 }}
  table {{ border-collapse: collapse }}
  th, td {{ padding: 0.2rem 0.8rem; border-bottom: 1px solid #ddd; text-align: right }}
  th:first-child, td:first-child {{ text-align: left }}
  .tiles :is(th, td) {{ min-width: 8rem; padding: 0.4rem; text-align: left; vertical-align: top }}
  .tiles img {{ display: block }}
  .failed {{ color: #b00; overflow-wrap: anywhere }}
  td.failed {{ text-align: left; max-width: 50rem }}
  button.turn {{ font: inherit; padding: 0.3rem 1rem }}
  model-viewer {{ width: min(40rem, 100%); height: 36rem; border: 1px solid #ddd; background: #f4f4f4 }}
</style>
<h1>{title}</h1>
{body}<script src="thumbnails/viewer/turntable.js"></script>
</html>
"""


def thumbnail(source, small, size, caption, link=None, cell=None):
    """A copy of a picture, with a link if there is one; nothing where it cannot be read.

    size: (width, height) at most. cell: (columns, k), to show the k-th of that many squares in the picture's first row.
    """
    try:
        with Image.open(source) as picture:
            picture = picture.convert("RGB")
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError):
        return ""
    if cell:
        columns, k = cell
        side = picture.width / (columns + (columns + 1) * GAP)
        left, top = (k + (k + 1) * GAP) * side, GAP * side
        picture = picture.crop([round(edge) for edge in (left, top, left + side, top + side)])
    picture.thumbnail(size)
    small.parent.mkdir(parents=True, exist_ok=True)
    picture.save(small, quality=85)
    width, height = picture.size
    about = f'alt="{html.escape(caption)}" width="{width}" height="{height}" loading="lazy"'
    shown = f'<img src="{quote(small.as_posix())}" {about}>'
    return f'<a href="{quote(link.as_posix())}">{shown}</a>' if link else shown


def links(folder, files):
    """Links to those files of a folder that are there, files by what to call them."""
    found = [f'<a href="{quote(str(folder / file))}">{name}</a>' for name, file in files.items()
             if (folder / file).is_file()]  # fmt: skip
    return ", ".join(found)


def turntable(source, script, name):
    """A button that shows a GLB in 3D, to be turned by hand; nothing where there is none. script: what holds it."""
    if not source.is_file():
        return ""
    path = quote(script.as_posix())
    packed = base64.b64encode(gzip.compress(source.read_bytes(), 6, mtime=0)).decode()
    script.parent.mkdir(parents=True, exist_ok=True)
    script.write_text(f"heads[{json.dumps(path)}] = {json.dumps(packed)};\n", "utf-8")
    viewer = quote((VIEWER / "model-viewer-umd.min.js").as_posix())
    about = f'data-head="{path}" data-viewer="{viewer}" data-name="{html.escape(name)}"'
    return f'<p><button class="turn" {about}>turn it</button></p>\n'


def write_page(page, title, body):
    """Write a page, and what it needs beside it."""
    VIEWER.mkdir(parents=True, exist_ok=True)
    for path in (COMMON / "turntable.js", *(COMMON / "viewer").iterdir()):
        shutil.copyfile(path, VIEWER / path.name)
    Path(page).write_text(PAGE.format(title=title, body=body), "utf-8")


def failure(steps):
    """A line that says what failed, or nothing; see ``reason``."""
    said = reason(steps)
    return said and f'<p class="failed">{html.escape(said)}</p>\n'


def reason(steps):
    """What failed, or did not come to its end, or nothing; steps: (name, file, log) in their order."""
    step = next((step for step in steps if not step[1].is_file()), None)
    if step is None:
        return ""
    name, _, log = step
    lines = log.read_text("utf-8", "replace").splitlines() if log.is_file() else []
    said = next((line for line in reversed(lines) if "error" in line), None)
    return f"{name} did not finish" if said is None else f"{name} failed: {said}"
