"""What pixels show by the detector and by their colours, in pictures with truth; and what snapping eyes to it does.

Usage: python benchmarks/parsing.py PICTURES [COUNT [DETECTOR]]. PICTURES: a folder of `caricli dataset pictures`; its
first COUNT (default: 40) pictures of test people with one face, of which at least 80 pixels and two fifths of the
landmarks are seen, and which the detector finds to 15 % of its diagonal. DETECTOR: default the bundled one.

Faces are fitted to the landmarks that were found. Of the pixels that texture paints skin with, by regions and by
colours (GrabCut and mixtures of Gaussians): "wrong", the share that shows no skin, and "seen", the share that they have
of all skin under the mesh; intersection over union of the head under the mesh, and of hair; of hats the share that
becomes hair. Eyes: errors of their landmarks, percent of the diagonal, as found, and snapped to the border of the eyes.
Seconds are means of processor time. The last line is JSON.
"""

import json
import sys
import time
from pathlib import Path

import cv2
import numpy as np
from threadpoolctl import threadpool_limits

from caricli.data.picture_set import read_picture_set
from caricli.errors import CaricliError
from caricli.methods.detect.parse_face import parse_face
from caricli.methods.detect.see_face import see_face
from caricli.methods.hair.mask_hair import mask_hair
from caricli.methods.hair.parsed_hair import is_before_head, parsed_hair
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.reconstruct.snap_eyes import snap_eyes
from caricli.methods.texture.mask_head import mask_head, mesh_pixels
from caricli.methods.texture.parsed_head import parsed_head
from caricli.store.detector import load_detector
from caricli.store.models import load_model
from caricli.structures.landmarks import EYES
from caricli.structures.parsing import Region

SKIN = [Region[name] for name in "SKIN BROWS EYES NOSE LIPS MOUTH TEETH EARS BEARD NECK".split()]
HEAD = [*SKIN, Region.HAIR, Region.HAT, Region.GLASSES]
SMALLEST = 80
SEEN = 0.4
FARTHEST = 0.15


def shared(first, second):
    """Intersection over union."""
    return (first & second).sum() / max((first | second).sum(), 1)


def timed(work, *arguments):
    """What work returns, and its seconds."""
    start = time.process_time()
    result = work(*arguments)
    return result, time.process_time() - start


def by_regions(face, image, detector, template):
    """Head, skin and hair by the detector, and seconds."""
    parsed, seconds = timed(parse_face, image, face.landmarks, detector)
    pixels = mesh_pixels(face, image)
    head = parsed_head(parsed.regions, pixels, image)
    if head is None:
        return None
    hair = parsed_hair(face, parsed.regions, pixels, image)
    if hair is None or not is_before_head(hair, pixels):
        hair = mask_hair(face, template, image)
    return head.whole, head.paint & ~around(hair.pixels, face), hair.pixels, seconds


def by_colours(face, image, template):
    """The same by colours."""
    head, seconds = timed(mask_head, face, image)
    hair, more = timed(mask_hair, face, template, image)
    skin = head & ~around(hair.pixels, face) if hair.trusted else head
    return head, skin, hair.pixels, seconds + more


def around(hair, face):
    """Hair with a margin, as texture leaves it."""
    reach = max(round(0.015 * np.ptp(face.landmarks[:, 1])), 1)
    return cv2.dilate(hair.astype(np.uint8), np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)) > 0


def figures(answer, truth, pixels):
    """Of one way on one picture."""
    head, skin, hair, seconds = answer
    painted = skin & pixels
    own = np.isin(truth, SKIN)
    hats = truth == Region.HAT
    return {
        "wrong": (painted & ~own).sum() / max(painted.sum(), 1),
        "seen": (painted & own).sum() / max((own & pixels).sum(), 1),
        "head": shared(head & pixels, np.isin(truth, HEAD) & pixels),
        "hair": shared(hair, truth == Region.HAIR) if (truth == Region.HAIR).any() else np.nan,
        "hats": (hair & hats).sum() / hats.sum() if hats.any() else np.nan,
        "seconds": seconds,
    }


def eye_errors(seen, true, visible):
    """Percent, as found and snapped."""
    points = seen.landmarks.head_points
    snapped, _ = snap_eyes(points, seen.regions == Region.EYES)
    diagonal = np.linalg.norm(np.ptp(true[:68], axis=0))
    ids = np.array(EYES)[visible[list(EYES)]]
    gaps = [np.linalg.norm(places[ids] - true[ids], axis=1) for places in (points, snapped)]
    return [100 * np.nanmean(gap) / diagonal if len(ids) else np.nan for gap in gaps]


def measured(pictures, detector, count):
    """Figures of both ways and errors of eyes, for each of so many pictures."""
    model = load_model()
    truth = pictures.truth
    for number in pictures.pictures_of("test"):
        rows = pictures.faces(number)
        if count == 0:
            return
        if len(rows) != 1 or truth["visible"][rows[0]].mean() < SEEN:
            continue
        true = truth["landmarks"][rows[0]]
        image = pictures.picture(number)
        if np.ptp(true, axis=0).max() < SMALLEST:
            continue
        try:
            seen = see_face(image, detector)
            marks = seen.landmarks
            diagonal = np.linalg.norm(np.ptp(true[:68], axis=0))
            if np.nanmean(np.linalg.norm(marks.head_points - true, axis=1)) > FARTHEST * diagonal:
                continue
            face = fit_landmarks(marks.head_points, model, spreads=marks.spreads).face
            answers = {
                "regions": by_regions(face, image, detector, model.template),
                "colours": by_colours(face, image, model.template),
            }
        except CaricliError as error:
            print(f"{number}: {error}", file=sys.stderr)
            continue
        if answers["regions"] is None:
            print(f"{number}: no head among the regions", file=sys.stderr)
            continue
        pixels = mesh_pixels(face, image)
        labels = pictures.regions(number)
        ways = {name: figures(answer, labels, pixels) for name, answer in answers.items()}
        yield ways | {"eyes": eye_errors(seen, true, truth["visible"][rows[0]])}
        count -= 1


@threadpool_limits.wrap(limits=1)
def main():
    """Print means and the JSON line."""
    pictures = read_picture_set(Path(sys.argv[1]))
    detector = load_detector(Path(sys.argv[3]) if len(sys.argv) > 3 else None)
    rows = list(measured(pictures, detector, int(sys.argv[2]) if len(sys.argv) > 2 else 40))
    summary: dict[str, object] = {"pictures": len(rows), "detector": detector.model_id}
    for way in ("regions", "colours"):
        means = {key: float(np.nanmean([row[way][key] for row in rows])) for key in rows[0][way]}
        print(way, " ".join(f"{key} {value:.3f}" for key, value in means.items()))
        summary[way] = means
    eyes = np.array([row["eyes"] for row in rows])
    errors = {"found": float(np.nanmean(eyes[:, 0])), "snapped": float(np.nanmean(eyes[:, 1]))}
    print("eyes found {found:.3f} % snapped {snapped:.3f} %".format(**errors))
    summary["eyes"] = errors
    print(json.dumps(summary))


if __name__ == "__main__":
    main()
