"""caricli train morphable: identity, expression and albedo in linear bases of their own."""

from caricli.commands.shared.linear_training import linear_command, train_and_write


@linear_command
def command(dataset, out, config, overrides, overwrite):
    """Train a linear morphable model, in which who somebody is and what the face does are separate.

    The dataset's columns identity and expression tell them apart; the expression neutral is none, or the commonest one
    where no mesh is neutral. Exaggerated meshes are left out, as the model is of normal faces; `--set exaggerated=true`
    takes them, too. The albedo basis comes from random colours of the head. Writes the model with its template and,
    beside it, a JSON with the recipe, the shape errors, and how well identity and expression agree where they should.

    \b
    Example:
      caricli train morphable --data dataset --out morphable.safetensors
      caricli train morphable --data dataset --out small.safetensors --set identity=32 --set expression=16
    """
    train_and_write("morphable", dataset, out, config, overrides, overwrite)
