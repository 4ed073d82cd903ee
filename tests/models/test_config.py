from dataclasses import FrozenInstanceError

import pytest

from caricli.errors import InputError
from caricli.io.bundled import config_path
from caricli.io.config import read_config, read_yaml
from caricli.models.ablation.config import AblationConfig
from caricli.models.coarse.config import CoarseConfig
from caricli.models.config import LinearConfig
from caricli.models.detector.config import DetectorConfig
from caricli.models.gesture.config import GestureConfig
from caricli.models.kernel.config import KernelConfig
from caricli.models.kinds import KINDS, config_class
from caricli.models.landmark_map.config import LandmarkMapConfig
from caricli.models.morphable.config import MorphableConfig
from caricli.models.sketch.config import SketchConfig
from caricli.models.strokes.config import StrokesConfig
from caricli.models.style.config import StyleConfig
from caricli.models.texture.config import TextureConfig

CONFIGS: dict[str, type] = {kind: config_class(kind) for kind in KINDS}
CONFIGS |= {"ablation": AblationConfig, "coarse": CoarseConfig, "detector": DetectorConfig}
CONFIGS |= {"landmark_map": LandmarkMapConfig, "sketch": SketchConfig, "style": StyleConfig}
CONFIGS |= {"texture": TextureConfig, "gesture": GestureConfig, "strokes": StrokesConfig}
FILES = sorted(config_path("").glob("*/*.yaml"))


def test_every_folder_of_settings_belongs_to_a_model():
    assert {path.parent.name for path in FILES} == set(CONFIGS)


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_files_name_only_what_differs_from_the_defaults(path):
    config = CONFIGS[path.parent.name]
    settings = read_config(path, config)
    for key in read_yaml(path) or {}:
        assert getattr(settings, key) != getattr(config(), key), key


@pytest.mark.parametrize(
    "path", [path for path in FILES if "variant" in (read_yaml(path) or {})], ids=lambda path: path.stem
)
def test_files_of_published_networks_leave_out_what_only_the_modern_one_reads(path):
    assert not read_yaml(path).keys() & {"stem", "blocks", "components", "mixed", "people", "camera_weight"}


def test_textures_as_published_have_one_look():
    assert read_config(config_path("texture/paper.yaml"), TextureConfig).looks == 0


def test_a_file_of_comments_alone_means_the_defaults(tmp_path):
    path = tmp_path / "default.yaml"
    path.write_text("# What caricli ships.\n")
    assert read_config(path, KernelConfig) == KernelConfig()


@pytest.mark.parametrize("kind", ["pca", "intrinsic"])
@pytest.mark.parametrize("name", ["tiny", "default", "paper"])
def test_the_bundled_settings_can_be_read(kind, name):
    config = read_config(config_path(f"{kind}/{name}.yaml"), config_class(kind))
    assert 1 <= config.dimension <= 178


@pytest.mark.parametrize("name", ["tiny", "default"])
def test_the_bundled_settings_of_the_kernel_model_can_be_read(name):
    config = read_config(config_path(f"kernel/{name}.yaml"), KernelConfig)
    assert config.components > config.dimension
    if name == "default":
        assert config == KernelConfig()


@pytest.mark.parametrize("setting", ["components=127", "centres=0", "width=0", "ridge=-1", "near=-1", "radius=0"])
def test_impossible_settings_of_the_kernel_model_are_refused(setting):
    with pytest.raises(InputError, match=setting.split("=")[0]):
        read_config(None, KernelConfig, [setting])


@pytest.mark.parametrize("name", ["tiny", "default"])
def test_the_bundled_settings_of_the_morphable_model_can_be_read(name):
    config = read_config(config_path(f"morphable/{name}.yaml"), MorphableConfig)
    assert (config == MorphableConfig()) == (name == "default")


@pytest.mark.parametrize("setting", ["identity=0", "expression=-1", "albedo=5000", "noise=0", "seed=-1"])
def test_impossible_settings_of_the_morphable_model_are_refused(setting):
    with pytest.raises(InputError, match=setting.split("=")[0]):
        read_config(None, MorphableConfig, [setting])


@pytest.mark.parametrize(("dimension", "seed"), [(1, 0), (4096, 2**31)])
def test_possible_settings_are_taken(dimension, seed):
    config = LinearConfig(dimension, seed)
    assert (config.dimension, config.seed) == (dimension, seed)


@pytest.mark.parametrize("setting", ["dimension=0", "dimension=4097", "dimension=-3", "seed=-1", "dimension=1.5"])
def test_impossible_settings_are_refused(setting):
    with pytest.raises(InputError, match=setting.split("=")[0]):
        read_config(None, LinearConfig, [setting])


def test_settings_do_not_change():
    with pytest.raises(FrozenInstanceError):
        LinearConfig().dimension = 3


@pytest.mark.parametrize("name", ["tiny", "default"])
def test_the_bundled_settings_of_the_landmark_map_can_be_read(name):
    config = read_config(config_path(f"landmark_map/{name}.yaml"), LandmarkMapConfig)
    assert (config == LandmarkMapConfig()) == (name == "default")


@pytest.mark.parametrize("setting", ["styles=0", "styles=137", "noise=0", "noise=2", "views=0", "width=3"])
def test_impossible_settings_of_the_landmark_map_are_refused(setting):
    with pytest.raises(InputError, match=setting.split("=")[0]):
        read_config(None, LandmarkMapConfig, [setting])


@pytest.mark.parametrize("setting", ["size=100", "widths=[8, 8]", "precision=half", "missing=1.5", "people=0"])
def test_impossible_settings_of_the_sketch_network_are_refused(setting):
    with pytest.raises(InputError, match=setting.split("=")[0]):
        read_config(None, SketchConfig, [setting])


@pytest.mark.parametrize("setting", ["width=2", "encoder=vgg", "size=30", "pictures=0", "precision=half", "batch=1"])
def test_impossible_settings_of_the_style_network_are_refused(setting):
    with pytest.raises(InputError, match=setting.split("=")[0]):
        read_config(None, StyleConfig, [setting])


@pytest.mark.parametrize("setting", ["size=60", "stride=0", "precision=half", "others=1", "epochs=0", "decay=1"])
def test_impossible_settings_of_the_gesture_network_are_refused(setting):
    with pytest.raises(InputError, match=setting.split("=")[0]):
        read_config(None, GestureConfig, [setting])


@pytest.mark.parametrize("setting", ["size=60", "patch=4", "widths=[8,8,8]", "precision=half", "points=0", "missing=2"])
def test_impossible_settings_of_the_stroke_network_are_refused(setting):
    with pytest.raises(InputError, match=setting.split("=")[0]):
        read_config(None, StrokesConfig, [setting])
