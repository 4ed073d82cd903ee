"""Who a model was trained with."""

from dataclasses import dataclass
from typing import Any

from caricli.errors import shown
from caricli.structures.checks import refuse

KEY = "people"
"""Of the recipe that a model, a landmark map or directions carry."""

MAKING = "making"
MESHES = "meshes"
"""What fingerprints are of: what generated people are made of, or the meshes of imported ones."""

BY = "people_by"
"""Of the same recipes, and of folders made of datasets: what the fingerprints are of."""

_USES = ("train", "validation")


@dataclass(frozen=True)
class SeenPeople:
    """Fingerprints of people (``caricli.data.unseen``), by what they were for.

    train: whose meshes a model was trained on. validation: whose meshes said how long. by: MAKING or MESHES or both,
    what the fingerprints are of; a recipe says it only where it is not MAKING alone, and older ones never do.
    """

    train: frozenset[str]
    validation: frozenset[str] = frozenset()
    by: frozenset[str] = frozenset({MAKING})

    @classmethod
    def of_recipe(cls, recipe: Any) -> "SeenPeople | None":
        """What a recipe says, or None where it says nothing. Raises InputError for what is no such list."""
        if not isinstance(recipe, dict) or KEY not in recipe:
            return None
        people = recipe[KEY]
        if not isinstance(people, dict) or set(people) != set(_USES):
            refuse(f"{KEY}: expected fingerprints for {' and '.join(_USES)}, found {shown(people, 60)}")
        if not all(isinstance(text, str) for text in people.values()):
            refuse(f"{KEY}: expected text, found {shown(people, 60)}")
        by = recipe.get(BY, MAKING)
        if not isinstance(by, str) or not by.split() or not {*by.split()} <= {MAKING, MESHES}:
            refuse(f"{BY}: expected {MAKING} or {MESHES} or both, found {shown(by, 60)}")
        train, validation = (frozenset(people[use].split()) for use in _USES)
        return cls(train, validation, frozenset(by.split()))

    def as_recipe(self) -> dict[str, Any]:
        """Entries for a recipe: fingerprints between blanks, in their order, and what these are of."""
        people = {KEY: {use: " ".join(sorted(getattr(self, use))) for use in _USES}}
        return people if self.by == {MAKING} else people | {BY: " ".join(sorted(self.by))}

    def before(self, split: str) -> frozenset[str]:
        """Whom nobody of a split of a dataset may be: trained on; for a test, looked at in any way."""
        return {"train": frozenset(), "validation": self.train}.get(split, self.train | self.validation)
