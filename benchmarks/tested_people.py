"""The people of the published test set, for benchmarks that draw their own faces of them."""

import yaml

from caricli.io.bundled import config_path


def tested_seed() -> int:
    """Seed of the test set: no bundled model was trained with its people."""
    return yaml.safe_load(config_path("testset.yaml").read_text("utf-8"))["seed"]
