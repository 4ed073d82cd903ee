"""What several commands load and show: models, templates, faces, progress."""

from contextlib import contextmanager

from caricli.errors import InputError
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint
from caricli.io.files import shown
from caricli.io.obj import ObjMesh


def load_model(path=None, kind="intrinsic"):
    """The model of a file, or the bundled one of a kind."""
    from caricli.models.checkpoint import model_from_checkpoint

    path = asset_path(f"{kind}.safetensors") if path is None else path
    return model_from_checkpoint(*read_checkpoint(path), shown(path))


def template_mesh(template, vertices):
    """Vertices with the polygons and UVs of their template, ready to be written as OBJ."""
    return ObjMesh(vertices, template.polygons, template.uvs, template.uv_polygons)


def check_topology(template, dataset_template, where):
    """Refuse a model and a dataset of different meshes."""
    if template.topology_id != dataset_template.topology_id:
        counts = len(template.vertices), len(dataset_template.vertices)
        raise InputError(f"{where}: its topology ({counts[0]} vertices) is not the dataset's ({counts[1]} vertices)")


def dataset_files(folder):
    """The files of a dataset folder, which no output may replace."""
    return [folder / "dataset.json", *folder.glob("*.npz")]


@contextmanager
def progress_bar(description):
    """Yield ``report(done, total)``: a bar with the time left on stderr where that is a terminal, else nothing."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as progress:
        task = progress.add_task(description, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)
