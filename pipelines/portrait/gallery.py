"""Write a page of the heads made of pictures, in the folder that holds them: gallery.py index.html NAME PICTURE...

A head that is not finished is shown as far as it came, with the error of the step that failed.
"""

import sys
from pathlib import Path

from caricli.io.page import PageFolder
from caricli.store.portrait_page import FILES, PortraitHead, write_portrait_page

sys.path.insert(0, str(Path(__file__).parents[1] / "common"))

from failures import reason


def head_of(name, picture):
    """The head of a picture."""
    folder = Path("heads", name)
    steps = [(step, folder / file, folder / "logs" / f"{step}.txt") for step, file in FILES.items()]
    return PortraitHead(name, Path(picture), folder, reason(steps))


def main(page, *given):
    """Write the page of pictures, each given by its name and its path."""
    heads = [head_of(name, picture) for name, picture in zip(given[::2], given[1::2], strict=True)]
    write_portrait_page(Path(page), PageFolder(), heads)


if __name__ == "__main__":
    main(*sys.argv[1:])
