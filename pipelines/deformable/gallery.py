"""Write the page of the workflow's results, in the folder that holds them: gallery.py index.html KIND..."""

import html
import json
import sys
from pathlib import Path

PAGE = """\
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Deformable 3D caricatures</title>
<style>
  body {{ max-width: 75rem; margin: 2rem auto; padding: 0 1rem; font: 1rem/1.5 system-ui, sans-serif; color: #222 }}
  img {{ max-width: 100% }}
  figure {{ margin: 1rem 0 2rem }}
  figcaption {{ color: #666 }}
  table {{ border-collapse: collapse }}
  th, td {{ padding: 0.2rem 0.8rem; border-bottom: 1px solid #ddd; text-align: right }}
  th:first-child, td:first-child {{ text-align: left }}
</style>
<h1>Deformable 3D caricatures</h1>
<p>{meshes} generated meshes; errors are mean distances of vertices in percent of the head's height.</p>
{sections}
</html>
"""


def table(heading, rows):
    """A table with a heading row."""
    lines = ["".join(f"<th>{html.escape(cell)}</th>" for cell in heading)]
    lines += ["".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows]
    return "<table>\n" + "\n".join(f"<tr>{line}</tr>" for line in lines) + "\n</table>\n"


def figure(path, caption, more=""):
    """A picture that is a link to itself, with a caption that may go on in HTML."""
    picture = f'<a href="{path}"><img src="{path}" alt="{caption}"></a>'
    return f"<figure>{picture}<figcaption>{caption}{more}</figcaption></figure>\n"


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
    sections = "".join(f"<h2>{heading}</h2>\n{part}" for heading, part in parts.items())
    page.write_text(PAGE.format(meshes=sum(shard["count"] for shard in shards), sections=sections), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
