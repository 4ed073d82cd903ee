"""Networks run on one core."""

import time
from concurrent.futures import ThreadPoolExecutor

import pytest
import torch

from caricli.models.inference import on_one_core


@pytest.fixture
def two_threads():
    usual = torch.get_num_threads()
    torch.set_num_threads(2)
    yield
    torch.set_num_threads(usual)


def test_it_runs_on_one_thread_without_gradients_and_others_have_theirs_again(two_threads):
    @on_one_core
    def look(failing: bool) -> tuple[int, bool]:
        if failing:
            raise ValueError
        return torch.get_num_threads(), torch.is_inference_mode_enabled()

    assert look(False) == (1, True) and torch.get_num_threads() == 2
    with pytest.raises(ValueError):
        look(True)
    assert torch.get_num_threads() == 2 and not torch.is_inference_mode_enabled()


def test_a_layer_says_the_same_on_any_number_of_cores(two_threads):
    layer = torch.nn.Linear(20_000, 500)
    values = torch.rand(1, 20_000, generator=torch.Generator().manual_seed(0))
    told = on_one_core(layer)(values)
    torch.set_num_threads(1)
    assert torch.equal(told, on_one_core(layer)(values))


def test_two_that_run_at_once_wait_for_each_other(two_threads):
    inside = []

    @on_one_core
    def look(number: int) -> int:
        inside.append(number)
        time.sleep(0.05)
        most = len(inside)
        inside.remove(number)
        return most

    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(look, range(2))) == [1, 1]
    assert torch.get_num_threads() == 2
