from dataclasses import replace

from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.faces.face_figures import face_figures, soundness
from caricli.structures import Face


def test_soundness_and_attributes(pca, strangers):
    face = encode_face(Face(pca.template.with_vertices(strangers[0])), pca)
    figures = face_figures(face, pca)
    assert soundness(face, pca) == {key: figures[key] for key in ("prior_rms", "flipped")}
    assert figures["prior_rms"] == face.prior_rms and "BigNose" in figures["attributes"]
    mirrored = replace(face, mesh=face.mesh.with_vertices(face.vertices * [-1, 1, 1]))
    flipped = flipped_triangles(mirrored.vertices, pca.template.gradients).mean()
    assert soundness(mirrored, pca)["flipped"] == flipped > figures["flipped"]
