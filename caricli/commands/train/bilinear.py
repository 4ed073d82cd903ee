"""caricli train bilinear: who somebody is times what the face does."""

from caricli.commands.shared.linear_training import linear_command, train_and_write


@linear_command
def command(dataset, out, config, overrides, overwrite):
    """Train a bilinear model, in which a face is who somebody is times what the face does (sketch paper, section 4.2).

    N-mode singular value decomposition of people by expressions: the dataset must be a full grid, as `caricli dataset
    build` makes it without --count. Writes the model with its template and, beside it, a JSON with the recipe and the
    shape errors.

    \b
    Example:
      caricli train bilinear --data grid --out bilinear.safetensors
      caricli train bilinear --data grid --out small.safetensors --set identity=20 --set expression=8
    """
    train_and_write("bilinear", dataset, out, config, overrides, overwrite)
