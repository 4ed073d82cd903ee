import pytest

from caricli.store.studio_token import private_link, studio_token


@pytest.fixture(autouse=True)
def path(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "caricli" / "studio-token"


def test_it_is_the_same_every_time_and_nobody_else_can_read_it(path):
    token = studio_token()
    assert len(token) == 22 and studio_token() == token
    assert path.read_text() == token and path.stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("damage", [lambda path: path.chmod(0o644), lambda path: path.write_text("short")])
def test_what_others_know_or_is_damaged_gives_way_to_another(path, damage):
    token = studio_token()
    damage(path)
    other = studio_token()
    assert other != token and studio_token() == other and path.stat().st_mode & 0o777 == 0o600


def test_a_link_is_not_followed(path, tmp_path):
    path.parent.mkdir()
    elsewhere = tmp_path / "elsewhere"
    elsewhere.write_text("x" * 22)
    elsewhere.chmod(0o600)
    path.symlink_to(elsewhere)
    assert studio_token() != "x" * 22 and elsewhere.read_text() == "x" * 22 and not path.is_symlink()


def test_without_a_cache_it_is_another_every_time(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert studio_token() != studio_token()


def test_the_words_of_a_browsers_command_line_tell_nobody(path):
    address = "http://127.0.0.1:8080/?a=1&token=secret"
    link = private_link(address)
    page = path.with_name("studio.html")
    assert "secret" not in link and link == page.as_uri() and page.stat().st_mode & 0o777 == 0o600
    assert 'content="0; url=http://127.0.0.1:8080/?a=1&amp;token=secret"' in page.read_text()
    assert private_link("http://localhost/") == link and "localhost" in page.read_text()


def test_without_a_cache_a_browser_opens_the_address_itself(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert private_link("http://localhost/") == "http://localhost/"
