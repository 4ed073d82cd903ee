"""caricli train intrinsic: principal components of deformation-gradient features."""

from caricli.commands.shared.linear_training import linear_command, train_and_write


@linear_command
def command(dataset, out, config, overrides, overwrite):
    """Train a linear model of deformations, which extrapolates without tearing.

    Writes the model with its template and, beside it, a JSON with the recipe and the shape errors.

    \b
    Example:
      caricli train intrinsic --data dataset --out intrinsic.safetensors
      caricli train intrinsic --data dataset --out small.safetensors --set dimension=32
    """
    train_and_write("intrinsic", dataset, out, config, overrides, overwrite)
