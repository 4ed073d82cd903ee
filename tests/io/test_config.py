import dataclasses
from dataclasses import dataclass

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from caricli.errors import InputError, UsageError
from caricli.io.config import read_config, read_yaml


@dataclass(frozen=True)
class Settings:
    rate: float = 1e-3
    steps: int = 10
    name: str = "pca"
    fast: bool = False
    widths: tuple[int, ...] = (1, 2)
    pair: tuple[float, float] = (0.0, 1.0)
    tags: list[str] = dataclasses.field(default_factory=list)
    limit: int | None = None

    def __post_init__(self):
        if self.steps < 1:
            raise ValueError(f"steps: expected at least 1, found {self.steps}")


@dataclass(frozen=True)
class Required:
    size: int


def read(folder, text, cls=Settings, overrides=()):
    path = folder / "a.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_config(path, cls, overrides)


NUMBER = st.floats(allow_nan=False, allow_infinity=False)
VALUES = st.builds(
    Settings,
    rate=NUMBER,
    steps=st.integers(1, 10**12),
    name=st.text(st.characters(exclude_categories=["Cs", "Cc"])),
    fast=st.booleans(),
    widths=st.lists(st.integers(-99, 99)).map(tuple),
    pair=st.tuples(NUMBER, NUMBER),
    tags=st.lists(st.sampled_from(["1", "null", "yes", "a: b", "&a", "!x", "2020-01-01", "~", ""])),
    limit=st.none() | st.integers(-99, 99),
)


@settings(max_examples=80, deadline=None, derandomize=True)
@given(value=VALUES)
def test_round_trip(tmp_path_factory, value):
    plain = {key: list(item) if isinstance(item, tuple) else item for key, item in dataclasses.asdict(value).items()}
    assert read(tmp_path_factory.mktemp("config"), yaml.safe_dump(plain, allow_unicode=True)) == value


def test_defaults_and_files(tmp_path):
    assert read_config(None, Settings) == Settings()
    assert read(tmp_path, "# nothing but a comment\n") == Settings()
    text = "rate: 1e-4\nsteps: 3\nname: x\nfast: true\nwidths: [4]\npair: [1, 2.5]\ntags: [a]\nlimit: 7\n"
    value = read(tmp_path, text)
    assert value == Settings(1e-4, 3, "x", True, (4,), (1.0, 2.5), ["a"], 7)
    assert type(value.pair[0]) is float
    assert read(tmp_path, "size: 3\n", Required) == Required(3)


def test_overrides_win(tmp_path):
    overrides = ("steps=5", "name=12", "widths=[7, 8]", "limit=null", "rate=2", "fast=true")
    value = read(tmp_path, "steps: 3\nlimit: 4\n", overrides=overrides)
    assert value == Settings(2.0, 5, "12", True, (7, 8), limit=None)
    assert read_config(None, Required, ["size=1", "size=2"]) == Required(2)
    assert read_config(None, Settings, ["name=a=b"]).name == "a=b"


BOMB = "a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("!!python/object/apply:os.system ['true']", "found the tag"),
        ("steps: !!python/name:os.system", "found the tag"),
        ("steps: !!int '3'", "found the tag"),
        ("steps: !thing 3", "found the tag"),
        (BOMB, "found an anchor or alias"),
        ("steps: *a", "found an anchor or alias"),
        ("speed: 3", "expected one of rate, .* found the key 'speed'"),
        ("3: 3", "found the key '3'"),
        ("null: 3", "found the key 'None'"),
        ("[1]: 3", "expected plain keys"),
        ("<<: {steps: 3}", "expected plain keys"),
        ("steps: 3\nsteps: 4", "'steps' twice"),
        ("tags: [{a: 1, a: 2}]", "'a' twice"),
        ("steps: 3.0", "steps: expected a whole number, found '3.0'"),
        ("steps: '3'", "steps: expected a whole number"),
        ("steps: true", "steps: expected a whole number"),
        ("steps: null", "steps: expected a whole number"),
        ("steps: 0", "a.yaml: steps: expected at least 1, found 0"),
        ("limit: x", "limit: expected a whole number or null"),
        ("rate: .nan", "rate: expected a finite number"),
        ("steps: 1_0", "a.yaml: steps: expected a plain decimal number of at most 18 digits, found '1_0'"),
        ("steps: 010", "a.yaml: steps: expected a plain decimal number of at most 18 digits, found '010'"),
        ("steps: 0x10", "a.yaml: steps: expected a plain decimal number of at most 18 digits, found '0x10'"),
        (f"steps: 1{'0' * 20}", "a.yaml: steps: expected a plain decimal number of at most 18 digits, found '10"),
        ("rate: 1:30", "a.yaml: rate: expected a plain decimal number of at most 18 digits, found '1:30'"),
        ("rate: 1.0e+400", r"a.yaml: rate: expected a plain decimal number that is finite, found '1.0e\+400'"),
        ("pair: [1, 0x10]", "a.yaml: pair: expected a plain decimal number of at most 18 digits, found '0x10'"),
        ("rate: -.inf", "rate: expected a finite number"),
        ("rate: 1e999", "rate: expected a finite number"),
        ("rate: fast", "rate: expected a finite number"),
        ("rate: true", "rate: expected a finite number"),
        ("name: 3", "name: expected text"),
        ("name: 2020-01-01", "name: expected text"),
        ("name: 2020-99-99", "expected YAML"),
        ("fast: 1", "fast: expected true or false"),
        ("widths: 3", "widths: expected a list of a whole number"),
        ("widths: [a]", "widths: expected a list"),
        ("pair: [1]", "pair: expected a list"),
        ("pair: [1, 2, 3]", "pair: expected a list"),
        ("tags: [" * 9 + "]" * 9, "nested at most 8 deep"),
        ("[" * 20000, "nested at most 8 deep"),
        ("- 1", "expected 'key: value' lines"),
        ("hello", "expected 'key: value' lines"),
        ("steps: [", "expected YAML"),
        ("steps: 3\n---\nsteps: 4\n", "expected YAML"),
        ("a\tb: \tc\n\t- x: 1", "expected YAML"),
        (b"steps: \xff", "in UTF-8"),
        (b"\0\1\2", "binary data"),
        ("name: \x07", "expected YAML"),
        ("<!doctype html><p>x</p>", "an HTML or XML page"),
        ("# " + "x" * 70_000, "at most 65536 bytes"),
    ],
)
def test_malformed(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, text)
    assert "a.yaml" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("steps", "--set: expected key=value, found 'steps'"),
        ("=3", "found the key ''"),
        ("speed=3", "found the key 'speed'"),
        ("steps=x", "--set steps=x: steps: expected a whole number, found 'x'"),
        ("steps=", "steps: expected a whole number"),
        ("steps=!!int 3", "found the tag"),
        ("widths=[1", "expected YAML"),
        ("steps=0x10", "--set steps=0x10: expected a plain decimal number of at most 18 digits, found '0x10'"),
    ],
)
def test_malformed_overrides(override, message):
    with pytest.raises(InputError, match=message):
        read_config(None, Settings, [override])


def test_the_blame_is_on_what_is_refused(tmp_path):
    limits = "steps: expected at least 1, found "
    for text, overrides, kind, message in [
        ("steps: 8", ("steps=0",), UsageError, f"--set steps=0: {limits}0"),
        ("steps: 8", ("fast=true", "steps=0"), UsageError, f"--set fast=true --set steps=0: {limits}0"),
        ("steps: -1", ("steps=0",), UsageError, f"--set steps=0: {limits}0"),
        ("steps: 0", ("fast=true",), InputError, f"{tmp_path / 'a.yaml'}: {limits}0"),
    ]:
        with pytest.raises(kind) as caught:
            read(tmp_path, text, overrides=overrides)
        assert type(caught.value) is kind and str(caught.value) == message
    assert read(tmp_path, "steps: 0", overrides=("steps=3",)).steps == 3


def test_plain_yaml(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("happy: {jawOpen: 0.5, mouthSmile: 1}\nneutral: {}\n")
    assert read_yaml(path) == {"happy": {"jawOpen": 0.5, "mouthSmile": 1}, "neutral": {}}
    for text, message in [
        ("a: !!str b", "tag"),
        ("a: 1\na: 2", "twice"),
        ("a: &x 1", "anchor"),
        ("a: [", "expected YAML"),
    ]:
        path.write_text(text)
        with pytest.raises(InputError, match=message):
            read_yaml(path)


def test_missing_fields():
    with pytest.raises(InputError, match="settings: expected the key 'size', found none"):
        read_config(None, Required)
