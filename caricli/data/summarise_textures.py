"""What a folder of textures holds, in a few lines."""

from collections import Counter
from collections.abc import Iterator

import numpy as np

from caricli.data.dataset import SPLITS
from caricli.data.texture_set import TextureSet


def summarise_textures(textures: TextureSet) -> list[str]:
    """Lines about people, levels, ages, what was seen, and splits."""
    people: Counter[int] = Counter()
    levels: Counter[int] = Counter()
    splits: Counter[str] = Counter()
    ages = []
    seen = []
    for one in textures.people():
        people[one.person] += 1
        levels[one.level] += 1
        splits[one.split] += 1
        ages.append(one.age)
        seen.append(one.seen.mean())
    return [
        f"people: {textures.count}, {len(people)} of the dataset; {textures.shown} expressions of each",
        f"textures: {textures.size} texels a side, {100 * np.mean(seen):.0f} % seen",
        f"levels: {', '.join(f'{levels[level]} at {level}' for level in sorted(levels))}",
        f"age of the skin: {np.min(ages):.2f} to {np.max(ages):.2f}",
        f"splits: {', '.join(f'{splits[name]} {name}' for name in SPLITS)}",
    ]


def chosen_textures(textures: TextureSet, count: int, generator: np.random.Generator) -> Iterator[np.ndarray]:
    """Rows of textures (S, E * S, 3) uint8, all of a person, of people at random."""
    chosen = np.sort(generator.permutation(textures.count)[:count])
    for number, one in enumerate(textures.people()):
        if number in chosen:
            yield np.hstack(list(one.pictures))
