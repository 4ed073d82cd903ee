"""Pictures of meshes: visibility, shading, previews, contact sheets."""
