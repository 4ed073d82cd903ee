"""Pictures that landmarks belong to."""

from caricli.errors import InputError, naming
from caricli.io.image import read_image

PICTURES = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff", ".gif")


def read_picture(image, marks, path):
    """The picture, if the landmarks can belong to it."""
    picture = read_image(image)
    size = picture.shape[1], picture.shape[0]
    if marks.image_size is not None and tuple(marks.image_size) != size:
        found = "{} x {}".format(*marks.image_size)
        raise InputError(f"{path}: expected landmarks of the {size[0]} x {size[1]} picture {image}, found {found}")
    with naming(path):
        marks.check_inside(size)
    return picture


def picture_beside(folder, path):
    """The picture in a folder that has the name of a landmark file."""
    if folder is None:
        return None
    if not folder.is_dir():
        raise InputError(f"{folder}: expected a folder of pictures, because results of many inputs were asked for")
    found = [folder / f"{path.stem}{suffix}" for suffix in PICTURES if (folder / f"{path.stem}{suffix}").is_file()]
    if not found:
        raise InputError(f"{folder}: expected a picture named {path.stem} with one of {', '.join(PICTURES)}")
    return found[0]
