"""What the code looks like: limits that keep a reader able to hold it in mind, counted on the syntax tree."""

import ast
from pathlib import Path

import pytest

import caricli

PACKAGE = Path(caricli.__file__).parent
LONGEST_BODY = 40
LONGEST_COMMAND = 25
MOST_PARAMETERS = 6
LONGEST_FILE = 400
MOST_PACKED = 0.03
VAGUE = {"known", "found", "made"}

MESH_PARTS = {"faces", "polygons", "uvs", "uv_polygons"}
CAMERA_PARTS = {"scale", "rotation", "translation"}
# Where a mesh or a camera is put together or taken apart, and where arrays are arrays, as in libigl.
PART_ROOMS = ("geometry", "io", "structures")
MAKERS = {"Mesh", "Template", "Camera"}


def trees(folder=PACKAGE):
    """Pairs of a path below the package and its syntax tree."""
    return [(path.relative_to(folder), ast.parse(path.read_text("utf-8"))) for path in sorted(folder.rglob("*.py"))]


def functions(tree):
    return [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]


def is_command(node):
    return any("command" in ast.unparse(decorator) for decorator in node.decorator_list)


def body_lines(node):
    first = node.body[1] if ast.get_docstring(node) is not None and len(node.body) > 1 else node.body[0]
    return node.end_lineno - first.lineno + 1


def parameters(node):
    return [argument.arg for argument in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)]


def packed(tree):
    """Assignments, and those among them that bind several names to several values at once."""
    assignments = [node for node in ast.walk(tree) if isinstance(node, ast.Assign)]
    pairs = [a for a in assignments if isinstance(a.targets[0], ast.Tuple) and isinstance(a.value, ast.Tuple)]
    return len(assignments), len(pairs)


def vague_names(tree):
    targets = (node.targets[0] for node in ast.walk(tree) if isinstance(node, ast.Assign))
    return [
        name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name) and name.id in VAGUE
    ]


def loose_parts(tree):
    """Lines that pass two parts of a mesh, or a whole camera's, as values of their own."""
    lines = []
    for node in functions(tree):
        names = {name.removeprefix("camera_") for name in parameters(node)}
        if len(names & MESH_PARTS) > 1 or names >= CAMERA_PARTS:
            lines.append(node.lineno)
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and ast.unparse(node.func).split(".")[-1] not in MAKERS:
            passed = [a.attr.removeprefix("camera_") for a in node.args if isinstance(a, ast.Attribute)]
            if len(set(passed) & MESH_PARTS) > 1 or set(passed) >= CAMERA_PARTS:
                lines.append(node.lineno)
        if isinstance(node, ast.Tuple) and isinstance(node.ctx, ast.Load):
            held = [e.attr.removeprefix("camera_") for e in node.elts if isinstance(e, ast.Attribute)]
            if len(set(held) & (MESH_PARTS - {"faces"})) > 1 or set(held) >= CAMERA_PARTS:
                lines.append(node.lineno)
    return lines


@pytest.fixture(scope="module")
def package():
    return trees()


def test_bodies_are_short(package):
    long = {f"{path}:{node.name}": body_lines(node) for path, tree in package for node in functions(tree)
            if body_lines(node) > (LONGEST_COMMAND if is_command(node) else LONGEST_BODY)}  # fmt: skip
    assert long == {}


def test_functions_take_few_parameters(package):
    many = {f"{path}:{node.name}": len(parameters(node)) for path, tree in package for node in functions(tree)
            if len(parameters(node)) > MOST_PARAMETERS and not is_command(node)}  # fmt: skip
    assert many == {}


def test_one_statement_does_one_thing(package):
    counts = [packed(tree) for _, tree in package]
    assert sum(pairs for _, pairs in counts) < MOST_PACKED * sum(assignments for assignments, _ in counts)


def test_variables_say_what_they_hold(package):
    assert {str(path): names for path, tree in package if (names := vague_names(tree))} == {}


def test_files_fit_into_a_head():
    lines = {
        path.relative_to(PACKAGE).as_posix(): path.read_text("utf-8").count("\n") for path in PACKAGE.rglob("*.py")
    }
    assert {name: count for name, count in lines.items() if count > LONGEST_FILE} == {}


def test_a_mesh_and_a_camera_travel_whole(package):
    rooms = [(path, tree) for path, tree in package if path.parts[0] not in PART_ROOMS]
    assert {str(path): lines for path, tree in rooms if (lines := loose_parts(tree))} == {}


@pytest.mark.parametrize(
    ("code", "count"),
    [
        ("def f(vertices, polygons, uvs): pass", 1),
        ("def f(camera_scale, camera_rotation, camera_translation): pass", 1),
        ("draw(mesh.polygons, mesh.uvs)", 1),
        ("parts = (template.polygons, template.uvs, template.uv_polygons)", 1),
        ("seen = pose.scale, pose.rotation, pose.translation", 1),
        ("draw(mesh, camera)", 0),
        ("igl.cotmatrix(mesh.vertices, mesh.faces)", 0),
        ("Mesh(head.vertices, head.polygons, head.uvs, head.uv_polygons)", 0),
    ],
)
def test_loose_parts_are_seen(code, count):
    assert len(loose_parts(ast.parse(code))) == count


def test_packed_and_vague_are_seen():
    tree = ast.parse("a, b = 1, 2\nfound = 3\nc, d = f()\n")
    assert packed(tree) == (3, 1) and vague_names(tree) == ["found"]
