import numpy as np

from caricli.data.identities import ASYMMETRY, EXCLUDED, random_identity


def test_same_generator_same_person(head):
    first, second = (random_identity(head, np.random.default_rng(4)) for _ in range(2))
    assert first == second
    assert first != random_identity(head, np.random.default_rng(5))


def test_people_stay_in_their_ranges(head):
    generator = np.random.default_rng(0)
    crowd = [random_identity(head, generator) for _ in range(100)]
    for person in crowd:
        assert 0 <= person.gender <= 1 and 0 <= person.weight <= 1 and 0.5 <= person.age <= 1
        assert set(person.changes) <= set(head.change_names) - set(EXCLUDED)
        assert max(map(abs, person.changes.values())) <= 1.6
    assert np.std([p.gender for p in crowd]) > 0.2 and np.std([p.age for p in crowd]) > 0.08


def test_left_and_right_differ_a_little(head):
    generator = np.random.default_rng(1)
    crowd = [random_identity(head, generator).changes for _ in range(100)]
    pairs = [(n, "l-" + n[2:]) for n in crowd[0] if n.startswith("r-")]
    assert len(pairs) > 10
    right, left = (np.array([[c[pair[k]] for pair in pairs] for c in crowd]) for k in (0, 1))
    assert 0 < (right - left).std() < 2 * ASYMMETRY * left.std()


def test_identities_make_different_heads(head):
    generator = np.random.default_rng(2)
    heads = [head.evaluate(**vars(random_identity(head, generator))) for _ in range(3)]
    assert np.linalg.norm(heads[0] - heads[1], axis=1).mean() > 1e-3
    assert np.linalg.norm(heads[1] - heads[2], axis=1).mean() > 1e-3
