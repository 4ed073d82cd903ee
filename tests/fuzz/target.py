"""One process of the fuzzer: libFuzzer over all readers; what is wrong goes into a folder, and it goes on.

python -m tests.fuzz.target FINDINGS READER,READER,... [options of libFuzzer] CORPUS
"""

import hashlib
import random
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["caricli"]):
    from tests.fuzz.judge import REPORT, judged
    from tests.fuzz.readers import READERS, Reader

_STRAY = 0.05
"""Share of the mutations of bytes among those of what is inside a file that has a frame."""


class Target:
    """Files in memory, each with the number of its reader before it, to readers."""

    def __init__(self, readers: list[Reader], findings: Path, folder: Path) -> None:
        """findings: folder for what is wrong. folder: for the files that readers are given."""
        self.readers = readers
        self.findings = findings
        self.folder = folder

    def try_one(self, data: bytes) -> None:
        """Give a file to its reader; a new kind of fault is written down with it."""
        if len(data) < 2:
            return
        reader = self.readers[data[0] % len(self.readers)]
        path = self.folder / reader.name
        path.write_bytes(data[1:])
        problem = judged(reader.read, path)
        if problem is None:
            return
        summary = problem.splitlines()[0]
        kind = hashlib.sha256(f"{reader.name}{summary.split(':')[0]}".encode()).hexdigest()[:8]
        place = self.findings / f"{kind}-{reader.name}"
        if not place.exists():
            place.write_bytes(data[1:])
            place.with_name(f"{place.name}{REPORT}").write_text(f"{reader.name}: {problem}\n", "utf-8")

    def mutate(self, data: bytes, most: int, seed: int) -> bytes:
        """Change the file, seldom its reader."""
        rng = random.Random(seed)
        if len(data) < 2 or rng.random() < 0.01:
            return bytes([rng.randrange(len(self.readers))]) + atheris.Mutate(data[1:], most - 1)
        reader = self.readers[data[0] % len(self.readers)]
        if reader.mutate is not None and rng.random() > _STRAY:
            # What is no longer a file of the kind has no inside.
            with suppress(Exception):
                changed = data[:1] + reader.mutate(data[1:], rng)
                return changed if len(changed) <= most else data
        return data[:1] + atheris.Mutate(data[1:], most - 1)


def main() -> None:
    """Write the good files into the corpus and start libFuzzer."""
    findings = Path(sys.argv[1])
    readers = [READERS[name] for name in sys.argv[2].split(",")]
    corpus = Path(sys.argv[-1])
    with tempfile.TemporaryDirectory() as folder:
        target = Target(readers, findings, Path(folder))
        for number, reader in enumerate(readers):
            for k, content in enumerate(reader.good_files(Path(folder))):
                data = bytes([number]) + content
                (corpus / f"seed-{reader.name}-{k}").write_bytes(data)
                target.try_one(data)
        atheris.Setup([sys.argv[0], *sys.argv[3:]], target.try_one, custom_mutator=target.mutate)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
