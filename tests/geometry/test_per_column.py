import numpy as np
import scipy.sparse as sp

from caricli.geometry.per_column import per_column


def test_every_batch_is_multiplied_on_its_own():
    generator = np.random.default_rng(0)
    matrix = sp.random(7, 5, 0.5, rng=generator, format="csr")
    values = generator.normal(size=(2, 3, 5, 4))
    found = per_column(matrix, values)
    assert found.shape == (2, 3, 7, 4)
    assert np.allclose(found, matrix.toarray() @ values)
    assert np.allclose(per_column(matrix, values[0, 0]), matrix @ values[0, 0])
    assert per_column(matrix, values[:0]).shape == (0, 3, 7, 4)
