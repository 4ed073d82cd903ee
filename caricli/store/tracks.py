"""What moves a rig, by path: weights of a face tracker, visemes over time, or mouth cues."""

from dataclasses import replace
from pathlib import Path

from caricli.errors import naming
from caricli.io.files import read_bytes
from caricli.io.takes.cues import is_cues, read_cues
from caricli.io.takes.track import KIND, OTHER_FPS, read_weights
from caricli.limits import MAX_FILE_BYTES
from caricli.methods.animate.speak_cues import act_visemes, speak_cues
from caricli.structures import Track
from caricli.structures.cues import viseme_name


def load_track(path: str | Path, source_fps: float | None = None, fps: float | None = None) -> Track:
    """The Track of a file, in ARKit's actions or whatever names it has that are no visemes.

    source_fps: frames a second of a recording that does not say. fps: those that are wanted, at which cues are spoken.
    Raises InputError.
    """
    if is_cues(read_bytes(path, MAX_FILE_BYTES, KIND)):
        cues = read_cues(path)
        with naming(path):
            return speak_cues(cues, source_fps or fps or OTHER_FPS)
    track = read_weights(path, source_fps)
    visemes = [viseme for viseme in map(viseme_name, track.names) if viseme is not None]
    if len(visemes) < len(track.names):
        return track
    with naming(path):
        return act_visemes(replace(track, names=tuple(visemes)))
