"""Run the commands of docs/gallery.md in a folder and draw its pictures again: make_pictures.py FOLDER [SECTION...].

A section is chosen by a command in its heading, such as `sample`; it takes what the sections before it left in FOLDER,
what `portrait` makes first of all. Without any, all are run, which takes hours.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).resolve().parent
WIDTH = 1200


def draw(folder, chosen):
    """Run the sections and write their pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"caricli": str(DOCS.parent), "PATH": path}
    for section in (DOCS / "gallery.md").read_text("utf-8").split("\n## ")[1:]:
        heading = section.partition("\n")[0]
        if chosen and not any(f"`{name}`" in heading for name in chosen):
            continue
        for script in re.findall(r"^```sh\n(.*?)^```$", section, re.S | re.M):
            print(script, end="", flush=True)
            subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=folder, env=environment, check=True)
        for target, sources in re.findall(r"\]\((\S+)\)<!-- (\S+(?: \S+)*) -->", section):
            if target.endswith(".gif"):
                shutil.copyfile(folder / sources, DOCS / target)
                continue
            picture = beside([Image.open(folder / source).convert("RGB") for source in sources.split()])
            picture.thumbnail((WIDTH, WIDTH))
            picture.save(DOCS / target, quality=85, optimize=True)


def beside(pictures):
    """Return one picture of pictures from left to right, as high as the lowest."""
    height = min(p.height for p in pictures)
    pictures = [p.resize((round(p.width * height / p.height), height)) for p in pictures]
    whole = Image.new("RGB", (sum(p.width for p in pictures), height))
    for k, picture in enumerate(pictures):
        whole.paste(picture, (sum(p.width for p in pictures[:k]), 0))
    return whole


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("sections", nargs="*")
    arguments = parser.parse_args()
    draw(arguments.folder, arguments.sections)
