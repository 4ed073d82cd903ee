"""caricli train pca: principal components of vertex positions."""

from caricli.commands.shared.linear_training import linear_command, train_and_write


@linear_command
def command(dataset, out, config, overrides, overwrite):
    """Train a linear model of vertex positions.

    Writes the model with its template and, beside it, a JSON with the recipe and the shape errors.

    \b
    Example:
      caricli train pca --data dataset --out pca.safetensors
      caricli train pca --data dataset --out small.safetensors --set dimension=32
    """
    train_and_write("pca", dataset, out, config, overrides, overwrite)
