from dataclasses import replace

from caricli.methods.texture.mouth_wall import mouth_wall


def test_it_begins_behind_the_lips(head_template):
    wall = mouth_wall(head_template)
    inside = head_template.mask("inner_mouth")
    assert (wall[~inside] == 0).all() and (wall[inside] == 1).mean() > 0.5
    corners = wall[head_template.faces]
    assert (corners.max(1) - corners.min(1)).max() < 0.5


def test_a_head_without_a_mouth_has_none(head_template):
    regions = {name: ids for name, ids in head_template.annotation.regions.items() if name != "inner_mouth"}
    head = replace(head_template, annotation=replace(head_template.annotation, regions=regions))
    assert not mouth_wall(head).any()
