from caricli.io.strict_json import write_json
from caricli.store.portrait_page import doubt_of_head


def test_the_doubt_of_a_head_is_that_of_the_face_that_was_taken(tmp_path):
    large = {"doubt": "its score is 0.50", "spread": 0.05}
    small = {"doubt": None, "spread": 0.02}
    path = tmp_path / "landmarks-regions.json"
    for faces, doubt in (([large], large["doubt"]), ([large, small], None), ([large, large], large["doubt"])):
        write_json(path, {"faces": faces})
        assert doubt_of_head(tmp_path) == doubt
