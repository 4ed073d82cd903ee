import sys
import tempfile

import numpy as np
import pytest
import torch

from caricli.errors import InputError, UsageError
from caricli.store.generators import load_generator

PICTURE = np.random.default_rng(0).integers(0, 256, (20, 30, 3), np.uint8)
READ = "from PIL import Image; import sys; a = Image.open(sys.argv[1])"


def script(code, places="{input} {output}"):
    """A command that runs a line of Python on the two files."""
    return f"{sys.executable} -c '{code}' {places}"


class Inverse(torch.nn.Module):
    def forward(self, levels):
        return 1.2 - 1.2 * levels


class Small(torch.nn.Module):
    def forward(self, levels):
        return levels[:, :, 1:]


class Grey(torch.nn.Module):
    def forward(self, levels):
        return levels[:, :1]


class Pair(torch.nn.Module):
    def forward(self, levels):
        return levels, levels


class Burst(torch.nn.Module):
    def forward(self, levels):
        return levels / (levels - levels)


class Picky(torch.nn.Module):
    def forward(self, levels):
        return levels.reshape(1, 3, 1024, 1024)


def saved(module, folder):
    torch.jit.script(module).save(str(folder / "module.pt"))
    return str(folder / "module.pt")


def test_a_command_paints(tmp_path):
    inverse = f"{READ}; from PIL import ImageOps; ImageOps.invert(a).save(sys.argv[2])"
    generator = load_generator(script(inverse), 60)
    np.testing.assert_array_equal(generator.paint(PICTURE), 255 - PICTURE)
    assert generator.file is None


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("import time; time.sleep(60)", "expected a picture within 0.5 s, found none"),
        ("import sys; sys.exit(3)", "expected exit 0, found 3"),
        ('raise ValueError("no such style")', "expected exit 0, found 1: ValueError: no such style"),
        ("pass", "expected a picture in {output}, found none"),
        ('import sys; open(sys.argv[2], "w").write("text")', "{output}: expected a PNG, JPEG, .* image, found"),
        (f"{READ}; a.resize((15, 10)).save(sys.argv[2])", "expected a picture of 30 x 20 pixels, found 15 x 10"),
    ],
)
def test_a_command_that_fails_says_why_in_a_line(code, message):
    with pytest.raises(InputError, match=message) as failure:
        load_generator(script(code), 0.5 if "sleep" in code else 60).paint(PICTURE)
    assert "\n" not in str(failure.value) and f"{tempfile.gettempdir()}/caricli-" not in str(failure.value)


def test_what_a_command_started_ends_with_it(tmp_path):
    started = f'import subprocess, time; subprocess.Popen(["sh", "-c", "sleep 2; touch {tmp_path}/late"])'
    with pytest.raises(InputError, match="found none"):
        load_generator(script(started), 60).paint(PICTURE)
    import time

    time.sleep(2.5)
    assert not (tmp_path / "late").exists()


@pytest.mark.parametrize("text", ["toon", "toon {input}", "toon {output}", "toon '{input} {output}"])
def test_a_command_that_cannot_work_is_wrong_usage(text):
    with pytest.raises(UsageError, match="--generator toon"):
        load_generator(text, 60)


def test_a_program_that_is_not_there_is_named():
    with pytest.raises(InputError, match="the generator nowhere-to-be-found: .* could not be started: No such file"):
        load_generator("nowhere-to-be-found {input} {output}", 60).paint(PICTURE)


def test_a_torchscript_file_paints_and_is_cut_off_at_white(tmp_path):
    path = saved(Inverse(), tmp_path)
    generator = load_generator(path, 1)
    np.testing.assert_array_equal(
        generator.paint(PICTURE), np.round(np.minimum(1.2 * (255.0 - PICTURE), 255)).astype(np.uint8)
    )
    assert str(generator.file) == path


@pytest.mark.parametrize(
    ("module", "message"),
    [
        (Small(), "expected a picture of 30 x 20 pixels, found 30 x 19"),
        (Grey(), r"expected a tensor \(1, 3, 20, 30\), found \(1, 1, 20, 30\)"),
        (Pair(), r"expected a tensor \(1, 3, 20, 30\), found tuple"),
        (Burst(), "expected finite colours, found 18.. that are not"),
        (Picky(), "expected it to map a picture, but it failed: .*shape"),
    ],
)
def test_a_module_that_does_not_fit_is_refused_in_a_line(module, message, tmp_path):
    with pytest.raises(InputError, match=message) as failure:
        load_generator(saved(module, tmp_path), 1).paint(PICTURE)
    assert "\n" not in str(failure.value) and "module.pt: " in str(failure.value)


@pytest.mark.parametrize("data", [b"", b"text", b"PK\x03\x04zip"])
def test_what_is_no_torchscript_is_refused_in_a_line(data, tmp_path):
    (tmp_path / "module.pt").write_bytes(data)
    with pytest.raises(InputError, match="module.pt: expected a TorchScript file") as failure:
        load_generator(str(tmp_path / "module.pt"), 1)
    assert "\n" not in str(failure.value)
