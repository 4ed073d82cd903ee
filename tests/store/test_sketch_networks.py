import pytest

from caricli.errors import InputError
from caricli.store.sketch_networks import has_sketch_network, load_sketch_basis, load_sketch_network


def test_without_a_bundled_network_it_is_said_how_to_make_one(monkeypatch):
    monkeypatch.setattr("caricli.store.sketch_networks.BUNDLED", "none.safetensors")
    assert not has_sketch_network()
    with pytest.raises(InputError, match="caricli train sketch"):
        load_sketch_network()


def test_a_basis_is_linear():
    assert len(load_sketch_basis().prior.mean) == 128
    with pytest.raises(InputError, match="linear model"):
        load_sketch_basis("kernel")
