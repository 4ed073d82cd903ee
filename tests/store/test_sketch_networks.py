import pytest

from caricli.errors import InputError
from caricli.store.sketch_networks import load_sketch_basis, load_sketch_pair
from caricli.template.feature_curves import feature_curves


def test_the_bundled_network_knows_the_bundled_model():
    network, basis = load_sketch_pair()
    assert network.basis == basis.model_id and network.label == "network"
    assert network.curves == tuple(curve.name for curve in feature_curves(basis.template.annotation))


def test_a_basis_is_linear():
    assert len(load_sketch_basis().prior.mean) == 128
    with pytest.raises(InputError, match="linear model"):
        load_sketch_basis("kernel")
