import pytest

from caricli.errors import InputError
from caricli.structures import SeenPeople

PEOPLE = SeenPeople(frozenset({"aa", "bb"}), frozenset({"cc"}))


def test_a_recipe_gives_them_back():
    assert SeenPeople.of_recipe({"seed": 0} | PEOPLE.as_recipe()) == PEOPLE
    assert PEOPLE.as_recipe() == {"people": {"train": "aa bb", "validation": "cc"}}
    assert SeenPeople.of_recipe(SeenPeople(frozenset()).as_recipe()) == SeenPeople(frozenset())


def test_a_recipe_says_what_fingerprints_are_of_where_it_is_not_what_heads_are_made_of():
    for by in ({"meshes"}, {"making", "meshes"}):
        people = SeenPeople(frozenset({"aa"}), by=frozenset(by))
        assert people.as_recipe()["people_by"] == " ".join(sorted(by))
        assert SeenPeople.of_recipe(people.as_recipe()) == people
    for by in ("", "names", ["meshes"], None):
        with pytest.raises(InputError, match="people_by: expected making or meshes or both, found"):
            SeenPeople.of_recipe(PEOPLE.as_recipe() | {"people_by": by})


def test_an_older_recipe_says_nothing():
    assert SeenPeople.of_recipe({"seed": 0}) is None and SeenPeople.of_recipe(None) is None


@pytest.mark.parametrize("people", [None, [], "aa", {"train": "aa"}, {"train": "aa", "validation": 3}])
def test_something_else_is_refused(people):
    with pytest.raises(InputError, match="people: expected"):
        SeenPeople.of_recipe({"people": people})


def test_a_split_shares_nobody_with_what_came_before_it():
    assert PEOPLE.before("train") == set()
    assert PEOPLE.before("validation") == {"aa", "bb"}
    assert PEOPLE.before("test") == {"aa", "bb", "cc"}
