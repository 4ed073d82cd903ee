"""Pictures of a few heads whose truth is known, of noise: who is in them is told by the landmarks alone."""

import numpy as np

from caricli.data.appearance import random_appearance
from caricli.data.dataset import Dataset
from caricli.data.picture_set import PictureWriter, encode_labels, encode_picture
from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.methods.pictures.build_pictures import PictureSettings, drawing_tasks
from caricli.methods.pictures.mime import random_mime
from caricli.methods.pictures.pose import Pose
from caricli.methods.pictures.settings import SitterSettings
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.seeds import PictureSeed
from caricli.structures.parsing import Region

MIMES = SitterSettings(twisted=0.5, grinning=0.5, laughing=0.3, loudest=1.5, widest=0.6, wide=0)
CHANCES = {"twisted": MIMES.twisted, "grinning": MIMES.grinning, "laughing": MIMES.laughing}
"""As much as the manifests of earlier pictures tell of them."""
SIZE = 96


def small_dataset(template, people):
    """A Dataset of heads (N, V, 3), each of another person; the last tests, the one before validates."""
    count = len(people)
    order = np.arange(count)
    splits = {"train": order[:-2].tolist(), "validation": [count - 2], "test": [count - 1]}
    flags = np.zeros((count, 0))
    zeros = np.zeros(count, int)
    vertices = people.astype(np.float32)
    return Dataset({"splits": splits}, template, vertices, order, zeros, zeros, (), flags, flags.astype(bool), {})


def write_posed_set(folder, dataset, count, seed, perspective=0.2):
    """Write a folder of pictures as `caricli dataset pictures` does, one face in each."""
    folder.mkdir()
    writer = PictureWriter(folder)
    settings = PictureSettings(count, SIZE, seed)
    for task in drawing_tasks(dataset, settings):
        faces = [_sitter(task, place, dataset.template, seed) for place in range(len(task.rows))]
        for number in range(task.count):
            generator = np.random.default_rng([seed, task.number, number])
            place = number % len(faces)
            row = int(task.rows[place])
            labels = {"person": dataset.identity[row], "expression": 0, "level": 0}
            truth = _posed(faces[place], dataset.template, perspective, generator)
            image = generator.integers(0, 256, (SIZE, SIZE, 3), np.uint8)
            regions = np.full((SIZE, SIZE), Region.SKIN, np.uint8)
            writer.add(encode_picture(image), encode_labels(regions), "flat", [truth | labels])
    about = {"settings": {"count": count, "size": SIZE, "seed": seed}, "sitter": CHANCES}
    about |= {"splits": dataset.manifest["splits"], "topology_id": dataset.template.topology_id}
    writer.finish(about)
    return folder


def _sitter(task, place, template, seed):
    generator = np.random.default_rng([seed, PictureSeed.SITTER, task.number, place])
    random_appearance(generator)
    vertices = task.vertices[place].astype(float)
    return vertices + random_mime(vertices, template, MIMES, generator)


def _posed(vertices, template, perspective, generator):
    rotation = head_rotation(generator.uniform(-0.3, 0.3, 3))
    middle = vertices.mean(0)
    pose = Pose(rotation, 220.0, np.array([48.0, 48.0]), perspective, middle, float(np.ptp(vertices[:, 1])))
    points = pose.place(vertices[landmark_vertices(vertices, rotation, template, 81)])[:, :2]
    own = {"landmarks": points, "visible": np.ones(81, bool), "rotation": rotation, "scale": pose.scale}
    own |= {"translation": pose.translation, "perspective": perspective, "light": np.zeros((9, 3))}
    return own | {"coefficients": np.zeros(239)}
