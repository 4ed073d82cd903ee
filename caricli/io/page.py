"""Pages that show results: small copies of pictures, heads to turn, and links; opened from disk, without a network."""

import base64
import gzip
import html
import json
import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from caricli.errors import InputError, shown
from caricli.io.bundled import asset_path
from caricli.io.files import read_start
from caricli.io.image import read_image
from caricli.io.outputs import writing

SMALL = "thumbnails"
"""Folder beside a page of what it shows; it moves with the page."""

VIEWER_FILE = "viewer/turntable.js"
"""In SMALL, what says that a page made it."""

_GENERATOR = '<meta name="generator" content="caricli">'
_VIEWER = Path(SMALL, "viewer")
_GAP = 0.03  # between the pictures of caricli's sheets, of their side
_PAGE = """\
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
{generator}
<title>{title}</title>
<style>
  body {{ margin: 2rem auto; padding: 0 1rem; max-width: 100rem; font: 1rem/1.5 system-ui, sans-serif; color: #222 }}
  .row {{ display: flex; flex-wrap: wrap; gap: 1rem }}
  figure {{ margin: 0 }}
  figure img {{ max-width: 100%; height: auto; border: 1px solid #ddd }}
  figcaption {{ color: #666 }}
  table {{ display: block; overflow-x: auto; border-collapse: collapse }}
  th, td {{ padding: 0.2rem 0.8rem; border-bottom: 1px solid #ddd; text-align: right }}
  th:first-child, td:first-child {{ text-align: left }}
  .tiles :is(th, td) {{ min-width: 8rem; padding: 0.4rem; text-align: left; vertical-align: top }}
  .tiles img {{ display: block }}
  .doubt {{ color: #850; text-align: left }}
  .failed {{ color: #b00; overflow-wrap: anywhere }}
  td.failed {{ text-align: left; max-width: 50rem }}
  button.turn {{ font: inherit; padding: 0.3rem 1rem }}
  model-viewer {{ width: min(40rem, 100%); height: 36rem; border: 1px solid #ddd; background: #f4f4f4 }}
</style>
<h1>{title}</h1>
{body}<script src="{viewer}/turntable.js"></script>
</html>
"""


@dataclass(frozen=True)
class SmallCopy:
    """A small copy of a picture.

    source: path. small: path of the copy in SMALL. size: (width, height) at most. cell: (columns, k), to show the k-th
    of that many squares in the picture's first row, or None for all of it.
    """

    source: Path
    small: Path
    size: tuple[int, int]
    cell: tuple[int, int] | None = None


@dataclass(frozen=True)
class PageFolder:
    """Where a page is made.

    home: folder that the page will stand in; what it links to lies there. staging: folder that its own files are
    written to, home itself or one from which they are moved there.
    """

    home: Path = Path()
    staging: Path = Path()

    def thumbnail(self, copy: SmallCopy, caption: str, link: Path | None = None) -> str:
        """A small copy of a picture, with a link to a file in home if there is one; nothing where it cannot be read."""
        size = self._shrunk(copy)
        if size is None:
            return ""
        about = f'alt="{html.escape(caption)}" width="{size[0]}" height="{size[1]}" loading="lazy"'
        image = f'<img src="{_url(Path(SMALL) / copy.small)}" {about}>'
        return f'<a href="{_url(link)}">{image}</a>' if link else image

    def _shrunk(self, copy: SmallCopy) -> tuple[int, int] | None:
        """Write the copy of a picture; its width and height, or None where it cannot be read."""
        from PIL import Image

        try:
            picture = Image.fromarray(read_image(copy.source))
        except InputError:
            return None
        if copy.cell:
            columns, k = copy.cell
            side = picture.width / (columns + (columns + 1) * _GAP)
            left = (k + (k + 1) * _GAP) * side
            top = _GAP * side
            picture = picture.crop((round(left), round(top), round(left + side), round(top + side)))
        picture.thumbnail(copy.size)
        path = self._file(copy.small)
        with writing(path):
            picture.save(path, quality=85)
        return picture.size

    def links(self, folder: Path, files: dict[str, str]) -> str:
        """Links to those files of a folder in home that are there, files by what to call them."""
        there = {name: folder / file for name, file in files.items() if (self.home / folder / file).is_file()}
        return ", ".join(f'<a href="{_url(path)}">{html.escape(name)}</a>' for name, path in there.items())

    def turntable(self, source: Path, script: Path, name: str) -> str:
        """A button that shows a GLB in 3D, to be turned by hand; nothing where there is none.

        source: path. script: path in SMALL of what holds it. name: of the head.
        """
        if not source.is_file():
            return ""
        url = _url(Path(SMALL) / script)
        packed = base64.b64encode(gzip.compress(source.read_bytes(), 6, mtime=0)).decode()
        path = self._file(script)
        with writing(path):
            path.write_text(f"heads[{json.dumps(url)}] = {json.dumps(packed)};\n", "utf-8")
        viewer = _url(_VIEWER / "model-viewer-umd.min.js")
        about = f'data-head="{url}" data-viewer="{viewer}" data-name="{html.escape(shown(name))}"'
        return f'<p><button class="turn" {about}>turn it</button></p>\n'

    def write(self, page: Path, title: str, body: str) -> None:
        """Write a page, and the viewer that it needs beside it. page: path. title: text. body: HTML."""
        folder = self.staging / _VIEWER
        text = _PAGE.format(generator=_GENERATOR, title=html.escape(title), body=body, viewer=_url(_VIEWER))
        with writing(page):
            folder.mkdir(parents=True, exist_ok=True)
            for path in sorted(asset_path("viewer").iterdir()):
                shutil.copyfile(path, folder / path.name)
            page.write_text(text, "utf-8")

    def _file(self, small: Path) -> Path:
        """The path of a file in SMALL, in a folder that is there."""
        path = self.staging / SMALL / small
        with writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
        return path


def is_page(path: Path) -> bool:
    """Whether a file is a page that was written here, and may be written anew."""
    return path.is_file() and _GENERATOR.encode() in read_start(path, 1024, "a page")


def _url(path: Path) -> str:
    return quote(os.fsencode(path.as_posix()))
