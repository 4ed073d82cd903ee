"""Write the page of the workflow's results, in the folder that holds them: gallery.py index.html KIND..."""

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "common"))

from plain_page import figure, table, write_page


def errors(folder):
    """The shape errors of all models by split."""
    models = json.loads((folder / "evaluation" / "shape.json").read_text("utf-8"))["models"]
    splits = list(next(iter(models.values())))
    rows = [
        [Path(path).stem, *(f"{found[split]['percent']:.3f}" for split in splits)] for path, found in models.items()
    ]
    return table(["model", *splits], rows)


def ablation(folder):
    """Errors of the networks during and after the training."""
    found = json.loads((folder / "ablation" / "ablation.json").read_text("utf-8"))
    names = ("train", "test", "surface")
    rows = [[m["name"], f"{m['parameters']:,}", *(f"{m[name]:.3f}" for name in names)] for m in found["models"]]
    heading = ["model", "parameters", "train", "test", "test, whole surface"]
    caption = f"{found['meshes']} training and {found['unseen']} test meshes"
    return figure("ablation/ablation.png", caption) + table(heading, rows)


def pictures(kind):
    """Random faces, the way from one to another, and a face from landmarks."""
    links = ", ".join(f'<a href="astronaut/{kind}.{suffix}">{suffix.upper()}</a>' for suffix in ("obj", "npz", "json"))
    return (
        figure(f"samples/{kind}/sheet.png", "random faces")
        + figure(f"interpolation/{kind}/strip.png", "from the first to the second")
        + figure(f"astronaut/{kind}.png", "landmarks given (green) and fitted (red)", f": {links}")
    )


def main(page, *kinds):
    """Write the page."""
    folder = page.parent
    shards = json.loads((folder / "dataset" / "dataset.json").read_text("utf-8"))["shards"]
    parts = {"Shape errors": errors(folder), "Ablation": ablation(folder)} | {kind: pictures(kind) for kind in kinds}
    if "deformable" in kinds:
        parts["deformable"] = figure("training/loss.png", "training") + parts["deformable"]
    meshes = sum(shard["count"] for shard in shards)
    about = f"{meshes} generated meshes; errors are mean distances of vertices in percent of the head's height."
    write_page(page, "Deformable 3D caricatures", about, parts)


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
