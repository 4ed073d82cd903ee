"""Binary glTF 2.0, which Blender, Unreal, Unity and three.js open."""
