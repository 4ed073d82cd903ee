"""How far hair on fitted heads is as their pictures show it, and what it costs.

Usage: python benchmarks/hair.py FACE.npz PICTURE [FACE.npz PICTURE ...]. Faces come from `caricli
reconstruct-from-landmarks LANDMARKS --image PICTURE --out FACE.npz`.

For every picture: the doubt of the mask, whether `--hair auto` trusts it, the intersection over union of hair as the
camera sees it with that mask, and seconds of processor time of the mask, the shell and its picture of 1024 texels,
medians of three; or that there is no hair. Whether the mask itself is right is for the eye. The last line is JSON.
"""

import json
import sys
import time
from pathlib import Path
from statistics import median

from caricli.io.image import read_image
from caricli.methods.hair.dress_hair import dress_hair, hair_picture
from caricli.methods.hair.mask_hair import mask_hair
from caricli.methods.texture.settings import PaintSettings
from caricli.store.faces import load_seen_face

SETTINGS = PaintSettings(size=1024, hair="shell")
ROUNDS = 3


def measure(face_file: Path, picture: Path) -> dict:
    """Figures of one picture."""
    face, model = load_seen_face(face_file)
    image = read_image(picture)
    if not mask_hair(face, model.template, image).pixels.any():
        return {"picture": picture.name, "trusted": False}
    times = []
    for _ in range(ROUNDS):
        start = time.process_time()
        dressed = dress_hair(face, model.template, image, SETTINGS)
        assert dressed is not None
        hair_picture(dressed, image, SETTINGS)
        times.append(time.process_time() - start)
    figures = {"picture": picture.name, "trusted": dressed.mask.trusted, "seconds": median(times)}
    return figures | dressed.figures()


if __name__ == "__main__":
    files = [Path(name) for name in sys.argv[1:]]
    results = [measure(*pair) for pair in zip(files[::2], files[1::2], strict=True)]
    for each in results:
        figures = {key: round(each[key], 3) for key in ("overlap", "doubt", "seconds") if key in each}
        print(f"{each['picture']}: {figures or 'no hair'}")
    print(json.dumps(results))
