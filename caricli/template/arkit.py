"""The names of the 52 facial actions of ARKit, which every engine's face tracking speaks."""

_SIDED = {
    "eye": ("Blink", "LookDown", "LookIn", "LookOut", "LookUp", "Squint", "Wide"),
    "jaw": ("",),
    "mouth": ("", "Smile", "Frown", "Dimple", "Stretch", "Press", "LowerDown", "UpperUp"),
    "brow": ("Down", "OuterUp"),
    "cheek": ("Squint",),
    "nose": ("Sneer",),
}
_WHOLE = (
    "jawForward",
    "jawOpen",
    "mouthClose",
    "mouthFunnel",
    "mouthPucker",
    "mouthRollLower",
    "mouthRollUpper",
    "mouthShrugLower",
    "mouthShrugUpper",
    "browInnerUp",
    "cheekPuff",
    "tongueOut",
)

ARKIT_NAMES = tuple(
    sorted(
        [part + action + side for part, actions in _SIDED.items() for action in actions for side in ("Left", "Right")]
        + list(_WHOLE)
    )
)
"""ARKit's spelling, in the order of the alphabet."""

LIVE_LINK_NAMES = tuple(name[0].upper() + name[1:] for name in ARKIT_NAMES)
"""How Live Link Face spells the same actions, in the same order."""
