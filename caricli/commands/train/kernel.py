"""caricli train kernel: principal components, the finer ones predicted from the coarser ones."""

from caricli.commands.shared.linear_training import linear_command, train_and_write


@linear_command
def command(dataset, out, config, overrides, overwrite):
    """Train a model of vertex positions that predicts fine components from coarse ones.

    A latent holds the coarse ones; a sparse Gaussian process adds the finer ones, and vertices near landmarks count
    more than others. Writes the model with its template and, beside it, a JSON with the recipe and the shape errors.

    \b
    Example:
      caricli train kernel --data dataset --out kernel.safetensors
      caricli train kernel --data dataset --out small.safetensors --set dimension=32 --set components=96
    """
    train_and_write("kernel", dataset, out, config, overrides, overwrite)
