"""What takes a while to start is started by those who need it alone."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import caricli
from caricli.io.face import write_face
from caricli.io.image import write_png
from caricli.io.parsing import legend, write_parsing
from caricli.io.strict_json import write_json
from caricli.structures import Face
from caricli.structures.parsing import Region

SLOW = "anny matplotlib rich scipy.ndimage scipy.optimize scipy.sparse.linalg skimage sklearn torch trimesh"
CODE = """
import sys
from caricli.__main__ import main
try:
    main()
finally:
    print(*sorted(set(%r.split()) & set(sys.modules)), file=sys.stderr)
"""


@pytest.fixture(scope="module")
def face(head, tmp_path_factory):
    path = tmp_path_factory.mktemp("face") / "face.npz"
    write_face(path, Face(head.template()))
    return path


@pytest.mark.parametrize("command", ["reconstruct-from-landmarks", "rig"])
def test_without_a_picture_nothing_is_started_that_draws(command, marks, face, tmp_path):
    picture = tmp_path / "plain.png"
    write_png(picture, np.full((400, 400, 3), 90, np.uint8))
    # Without a label map the detector looks at the picture.
    labels = tmp_path / "labels.png"
    write_parsing(labels, np.full((400, 400), Region.SKIN, np.uint8))
    write_json(labels.with_suffix(".json"), legend(Region))
    given = {
        "reconstruct-from-landmarks": [marks, "--image", picture, "--parsing", labels, "--out", tmp_path / "fit.obj"],
        "rig": [face, "--neutral", "as-is", "--parts", "skin,eyes", "--out", tmp_path / "rig.glb"],
    }[command]
    code = CODE % f"{SLOW} warp"
    words = [sys.executable, "-c", code, command, *map(str, given), "--no-picture"]
    environment = os.environ | {"PYTHONPATH": str(Path(caricli.__file__).parents[1])}
    done = subprocess.run(words, capture_output=True, text=True, env=environment, check=True)
    assert done.stderr == "\n"
