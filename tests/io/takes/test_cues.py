import json

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.takes.cues import is_cues, read_cues

JSON = {
    "metadata": {"soundFile": "a.wav", "duration": 0.9},
    "mouthCues": [
        {"start": 0.0, "end": 0.2, "value": "X"},
        {"start": 0.2, "end": 0.31, "value": "A"},
        {"start": 0.31, "end": 0.9, "value": "E"},
    ],
}
TSV = "0.00\tX\n0.20\tA\n0.31\tE\n0.90\tX\n"
XML = """<?xml version="1.0" encoding="utf-8"?>
<rhubarbResult>
  <metadata><soundFile>a.wav</soundFile><duration>0.90</duration></metadata>
  <mouthCues>
    <mouthCue start="0.00" end="0.20">X</mouthCue>
    <mouthCue start="0.20" end="0.31">A</mouthCue>
    <mouthCue start="0.31" end="0.90">E</mouthCue>
  </mouthCues>
</rhubarbResult>
"""


def written(path, text):
    path.write_text(text if isinstance(text, str) else json.dumps(text))
    return path


@pytest.mark.parametrize("text", [JSON, TSV, XML, "\ufeff" + TSV.replace("\n", "\r\n")])
def test_the_three_forms_of_rhubarb_say_the_same(tmp_path, text):
    path = written(tmp_path / "cues", text)
    assert is_cues(path.read_bytes())
    cues = read_cues(path)
    assert cues.names[:3] == ("rhubarb_X", "rhubarb_A", "rhubarb_E")
    np.testing.assert_allclose(cues.starts[:3], [0, 0.2, 0.31])
    assert cues.end == pytest.approx(0.9, abs=2e-3)


def test_visemes_come_in_the_same_forms_and_their_e_is_another(tmp_path):
    cues = read_cues(written(tmp_path / "a.tsv", "0.0\tsil\n0.1\tE\n0.2\tviseme_PP\n0.3\tI\n0.4\tsil\n"))
    assert cues.names == ("viseme_sil", "viseme_E", "viseme_PP", "viseme_ih", "viseme_sil")


def test_where_no_cue_is_the_mouth_rests(tmp_path):
    entries = [{"start": 0.5, "end": 0.6, "value": "D"}, {"start": 0.8, "end": 1, "value": "D"}]
    cues = read_cues(written(tmp_path / "a.json", {"metadata": {"duration": 2}, "mouthCues": entries}))
    assert cues.names == ("viseme_sil", "rhubarb_D", "viseme_sil", "rhubarb_D", "viseme_sil")
    assert cues.starts.tolist() == [0, 0.5, 0.6, 0.8, 1] and cues.end == 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ({"mouthCues": []}, "expected 1 to"),
        ({"mouthCues": 3}, "expected a list 'mouthCues'"),
        ({"mouthCues": [{"start": 0}]}, "cue 0: expected start, end and value"),
        ({"mouthCues": [{"start": "x", "end": 1, "value": "A"}]}, "cue 0: expected seconds, found x"),
        ({"mouthCues": [{"start": 0, "end": 1, "value": "Q"}]}, "cue 0: expected one of Rhubarb's letters"),
        ({"mouthCues": [{"start": 1, "end": 0.5, "value": "A"}]}, "cue 0: expected an end after its start at 1 s"),
        ({"mouthCues": [*JSON["mouthCues"], JSON["mouthCues"][0]]}, "cue 3: expected one after the other"),
        ("0.00\tX\n0.20 A\n", "line 2: expected seconds and a name"),
        ("0.00\tX\n1e99\tA\n", "line 2: expected seconds"),
        ("\n\n0.00\tX\n1e99\tA\n", "line 4: expected seconds"),
        ("<rhubarbResult><mouthCues>", "expected the XML of Rhubarb"),
        ("<other/>", "expected <rhubarbResult>, found <other>"),
        ('<!DOCTYPE a [<!ENTITY b "b">]><rhubarbResult>&b;</rhubarbResult>', "found entities or references"),
    ],
)
def test_what_is_no_speech_is_refused(tmp_path, text, said):
    with pytest.raises(InputError, match="a.cues: ") as caught:
        read_cues(written(tmp_path / "a.cues", text))
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_entities_do_not_grow_in_another_encoding(tmp_path):
    grown = '<!DOCTYPE a [<!ENTITY b "bbbb"><!ENTITY c "&b;&b;">]>'
    text = f"{grown}<rhubarbResult><mouthCues><mouthCue start='0' end='1'>&c;</mouthCue></mouthCues></rhubarbResult>"
    for encoding in ("utf-16-le", "utf-16-be", "utf-16"):
        (tmp_path / "a.cues").write_bytes(text.encode(encoding))
        with pytest.raises(InputError, match="found "):
            read_cues(tmp_path / "a.cues")


@pytest.mark.parametrize("start", [b"{}", b"timecode,", b"0.1 0.2\n", b"<html>", b"\x00", b"v 1 2 3"])
def test_other_files_are_no_cues(start):
    assert not is_cues(start)
