"""The page of heads that were made of pictures."""

import html
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from caricli.errors import InputError, shown
from caricli.io.outputs import check_output_folder, check_outputs, staged, staged_folder
from caricli.io.page import SMALL, VIEWER_FILE, PageFolder, SmallCopy, is_page
from caricli.io.strict_json import read_json

FILES = {
    "detect": "landmarks.json",
    "reconstruct": "face.npz",
    "refine": "refined.npz",
    "texture": "textured/face.npz",
    "rig": "rig.glb",
}
"""What the steps write into the folder of a head, in their order."""

REPORT = "portrait.json"
"""What says that a folder is that of a head, and what it was made of."""

SHEET = "sheet.png"
"""Picture of the picture and its head."""

_PAGE = "index.html"

TAKEN = (_PAGE, SMALL)
"""Names beside the folders of heads, which no head can have."""

_COPY = "picture.jpg"
_SHEET = (1600, 1600)  # pixels: heads of it stay large enough to see
_PICTURE = (1600, 480)
_SHEETS = {
    "head": SHEET,
    "caricature": "styled-sheet.png",
    "found": "landmarks-overlay.png",
    "fit": "refined.png",
    "texture": "textured/sheet.png",
    "expressions": "rig.png",
}
_LINKS = {"rig": "rig.glb", "head": "textured/face.glb", "OBJ": "textured/face.obj", "NPZ": "textured/face.npz"}
_BODY = """\
<p>{done} of {count} finished. Landmarks: how far those that were found may be off. NME: how far the head's are from
them, before and after refine; both in percent of their bounding box's diagonal. Photometric error: mean difference
between the picture and the textured head in its place, in percent of full scale.</p>
<table>
<tr><th>picture</th><th>landmarks</th><th>NME</th><th>refined</th><th>photometric</th><th></th></tr>
{rows}
</table>
{sections}
"""


@dataclass(frozen=True)
class PortraitHead:
    """A head that was made of a picture, as far as it came.

    name: of the picture. picture: its path. folder: of its files, in the home of the page. failed: why it is not
    finished, or nothing.
    """

    name: str
    picture: Path
    folder: Path
    failed: str = ""


def portrait_heads(home: Path, names: Mapping[Path, str], failures: Mapping[Path, str]) -> list[PortraitHead]:
    """The heads in a folder, of this run and of others, and those that failed now; folders of something else are none.

    names: of the heads of this run, by their pictures. failures: why, by the picture.
    """
    given = {name: path for path, name in names.items()}
    heads = {}
    for report in home.glob(f"*/{REPORT}"):
        name = report.parent.name
        if _told(report, "command") == "portrait":
            # What another run was given is shown as the page has it: a path in a file is not followed elsewhere.
            heads[name] = PortraitHead(name, given.get(name, home / SMALL / name / _COPY), Path(name))
    lacking = [(names[path], path, text) for path, text in failures.items()]
    heads |= {name: PortraitHead(name, path, Path(name), text) for name, path, text in lacking}
    return [heads[name] for name in sorted(heads, key=_natural)]


def _natural(name: str) -> list[tuple[bool, int, str]]:
    """What names are ordered by: 2 comes before 10."""
    parts = re.split(r"(\d+)", name.lower())
    return [(not part.isdecimal(), int(part) if part.isdecimal() else 0, part) for part in parts]


def check_page(home: Path, overwrite: bool, inputs: Iterable[Path | None]) -> None:
    """Refuse at once what ``write_page`` would refuse. Raises OutputError."""
    inputs = list(inputs)
    check_outputs(home / _PAGE, overwrite=_goes(home, overwrite), inputs=inputs)
    check_output_folder(home / SMALL, True, inputs, VIEWER_FILE)


def write_page(home: Path, heads: list[PortraitHead], overwrite: bool, inputs: Iterable[Path | None]) -> None:
    """Write index.html of heads into the folder that holds them, and what it shows; a page of earlier heads is written
    anew. Raises OutputError."""
    inputs = list(inputs)
    with (
        staged_folder(home / SMALL, True, inputs, VIEWER_FILE) as small,
        staged(home / _PAGE, overwrite=_goes(home, overwrite), inputs=inputs) as (page,),
    ):
        write_portrait_page(page, PageFolder(home, small.parent), heads)


def _goes(home: Path, overwrite: bool) -> bool:
    """Whether what stands where a page is to be may be replaced: a page of earlier heads is."""
    return overwrite or is_page(home / _PAGE)


def _found(folder: Path) -> dict[str, Any]:
    """What is known of the face that was found; nothing where none was looked for."""
    regions = folder / "landmarks-regions.json"
    faces = _told(regions, "faces") if regions.is_file() else [_told(folder / "styled-report.json", "detected")]
    faces = [face for face in faces if isinstance(face, dict)] if isinstance(faces, list) else []
    # The largest that nothing speaks against, or the largest: that is the face whose landmarks `detect` wrote.
    return next((face for face in faces if face.get("doubt") is None), faces[0] if faces else {})


def doubt_of_head(folder: Path) -> str | None:
    """What speaks against the face that a head was made of, or None."""
    doubt = _found(folder).get("doubt")
    return doubt if isinstance(doubt, str) else None


def describe_head(folder: Path) -> str:
    """What is printed of a finished head."""
    sure, _, refined, photometric = _figures(folder)
    doubt = f"landmarks to {sure} %, " if sure else ""
    return f"{doubt}NME {refined} %, photometric error {photometric} %, rig.glb with 52 expressions"


def write_portrait_page(page: Path, where: PageFolder, heads: list[PortraitHead]) -> None:
    """Write a page of heads with their errors, their sheets and a viewer. page: path. Raises OutputError."""
    body = _BODY.format(
        done=sum(not head.failed for head in heads),
        count=len(heads),
        rows="\n".join(_row(head, where) for head in heads),
        sections="".join(_section(head, where) for head in heads),
    )
    where.write(page, "Portraits", body)


def _figures(folder: Path) -> list[str]:
    """What the table says of a head: how sure its landmarks are, NME before and after refine, photometric error;
    percent, empty where unknown."""
    refined = folder / "refined.json"
    return [
        _number(_found(folder).get("spread"), 100, 1),
        _number(_told(refined, "before", "all"), 1, 2),
        _number(_told(refined, "after", "all"), 1, 3),
        _number(_told(folder / "textured/face.json", "photometric_error"), 100, 2),
    ]


def _number(value: Any, unit: int, digits: int) -> str:
    """The text of a number of units, or nothing where it is none."""
    return f"{unit * value:.{digits}f}" if isinstance(value, float) else ""


def _told(path: Path, *keys: str) -> Any:
    """What a report says under keys, or None where it says nothing: anybody may have written it."""
    try:
        value = read_json(path) if path.is_file() else None
    except InputError:
        return None
    for key in keys:
        value = value.get(key) if isinstance(value, dict) else None
    return value


def _row(head: PortraitHead, where: PageFolder) -> str:
    """Its line of the table."""
    cells = "".join(f"<td>{cell}</td>" for cell in _figures(where.home / head.folder))
    name = f'<a href="#{_anchor(head)}">{html.escape(shown(head.name))}</a>'
    return f"<tr><td>{name}</td>{cells}{_said(head, where, 'td')}</tr>"


def _anchor(head: PortraitHead) -> str:
    """What the line of a head in the table leads to; names need not be UTF-8."""
    return quote(os.fsencode(head.name))


def _said(head: PortraitHead, where: PageFolder, tag: str) -> str:
    """What failed or is doubtful, in a tag."""
    doubt = doubt_of_head(where.home / head.folder)
    kind = "doubt" if doubt and not head.failed else "failed"
    text = head.failed or (f"doubtful: {doubt}" if doubt else "")
    return f'<{tag} class="{kind}">{html.escape(shown(text))}</{tag}>' if text or tag == "td" else ""


def _section(head: PortraitHead, where: PageFolder) -> str:
    """What there is of the head of one picture."""
    small = Path(head.name)
    figures = _figure(SmallCopy(head.picture, small / _COPY, _PICTURE), "picture", where)
    for caption, file in _SHEETS.items():
        copy = SmallCopy(where.home / head.folder / file, small / f"{caption}.jpg", _SHEET)
        figures += _figure(copy, caption, where, head.folder / file)
    title = f'<h2 id="{_anchor(head)}">{html.escape(shown(head.name))}</h2>\n{_said(head, where, "p")}'
    turning = where.turntable(where.home / head.folder / FILES["rig"], small / "rig.js", head.name)
    links = where.links(head.folder, _LINKS)
    return f'{title}{turning}<div class="row">\n{figures}</div>\n<p>{links}</p>\n'


def _figure(copy: SmallCopy, caption: str, where: PageFolder, link: Path | None = None) -> str:
    """A small copy of a picture with its caption; nothing where it cannot be read."""
    image = where.thumbnail(copy, caption, link)
    return f"<figure>{image}<figcaption>{caption}</figcaption></figure>\n" if image else ""
