"""How well the face of a stylised portrait is found where its pixels went.

Of several faces that are seen the one that is nearest counts.

Usage: python benchmarks/stylise.py PICTURE LANDMARKS [SHEET.png [DETECTOR.safetensors]]. For every style at three
strengths: mean distance of the 68 landmarks that `caricli detect` finds from those that went the way of the pixels, in
percent of their diagonal; the first row is the portrait itself against LANDMARKS. SHEET.png shows all of them. The last
line is JSON.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

from caricli.io.image import write_png
from caricli.methods.detect.detect_faces import detect_faces
from caricli.methods.stylise.settings import STYLES, StyliseSettings
from caricli.methods.stylise.stylise_portrait import stylise_portrait
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.render.sheets.crop_portrait import crop_portrait
from caricli.store.detector import load_detector
from caricli.store.pictures import load_marked_picture
from caricli.store.shape_tools import load_shape_tools
from caricli.structures.landmarks import COUNT

STRENGTHS = (0.0, 1.0, 2.0)
SIZE = 360


def nme(image, points, detector):
    """Percent, of the nearest face; NaN where none is found."""
    diagonal = np.linalg.norm(np.ptp(points[:COUNT], axis=0))
    faces = [face.landmarks.head_points[:COUNT] - points[:COUNT] for face in detect_faces(image, detector).faces]
    errors = [100 * np.nanmean(np.linalg.norm(missed, axis=1)) / diagonal for missed in faces]
    return float(min(errors, default=np.nan))


def rows(image, marks, detector):
    """Yield one row for each style and strength, and its picture."""
    tools = load_shape_tools(StyliseSettings())
    for style in STYLES:
        for strength in STRENGTHS:
            start = time.process_time()
            result = stylise_portrait(image, marks, tools, StyliseSettings(style, strength=strength))
            seconds = time.process_time() - start
            error = nme(result.picture, result.landmarks.head_points, detector)
            row = {"style": style, "strength": strength, "nme": error, "moved": result.moved, "cpu_seconds": seconds}
            yield row, crop_portrait(result.picture, result.landmarks.points, SIZE)


def main():
    """Print the table and write the sheet."""
    picture, landmarks, *more = map(Path, sys.argv[1:])
    marks, image = load_marked_picture(landmarks, picture)
    detector = load_detector(more[1] if len(more) > 1 else None)
    given = nme(image, marks.head_points, detector)
    print(f"given: NME {given:.2f} %")
    table = []
    pictures = []
    for row, head in rows(image, marks, detector):
        table.append(row)
        pictures.append(head)
        print("{style:12} {strength:3g}  NME {nme:5.2f} %  moved {moved:5.2f} %  {cpu_seconds:.1f} s".format(**row))
    if more:
        labels = [f"{row['style']} {row['strength']:g}" for row in table]
        write_png(more[0], contact_sheet(pictures, len(STRENGTHS), labels))
    print(json.dumps({"given": given, "rows": table}))


if __name__ == "__main__":
    main()
