"""The nouns: frozen, checked once where they are made, without paths."""

from caricli.structures.camera import Camera
from caricli.structures.cues import Cues
from caricli.structures.depiction import Depiction
from caricli.structures.directions import Directions
from caricli.structures.face import Face
from caricli.structures.head_choice import HeadChoice
from caricli.structures.landmarks import Landmarks
from caricli.structures.materials import Material
from caricli.structures.mesh import Mesh
from caricli.structures.parts import Hair, Part
from caricli.structures.pictures import Mood, Pictures
from caricli.structures.rig import Rig
from caricli.structures.seen_people import SeenPeople
from caricli.structures.session import Operation, Session, Start
from caricli.structures.sketch import Sketch, Stroke, StrokeKind
from caricli.structures.track import Animation, Track

__all__ = [
    "Animation",
    "Camera",
    "Cues",
    "Depiction",
    "Directions",
    "Face",
    "Hair",
    "HeadChoice",
    "Landmarks",
    "Material",
    "Mesh",
    "Mood",
    "Operation",
    "Part",
    "Pictures",
    "Rig",
    "SeenPeople",
    "Session",
    "Sketch",
    "Start",
    "Stroke",
    "StrokeKind",
    "Track",
]
