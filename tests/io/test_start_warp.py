import os
import subprocess
import sys

import pytest

DRAW = """
import numpy as np
from caricli.render.visibility.rasterise import rasterise
r = rasterise(np.array([[0.0, 0, 0], [9, 0, 0], [0, 9, 0]]), [[0, 1, 2]], 4, 4)
assert (r.face == 0).all()
import warp
open(3, "w").write(warp.config.kernel_cache_dir)
"""

AT_ONCE = """
import os, threading, time
import warp
from caricli.io import start_warp as module
init = warp.init
def slow():
    starts.append(threading.get_ident())
    time.sleep(0.2 * len(starts))  # the first ends first: it puts back what it kept while the second still runs
    init()
def start():
    barrier.wait()
    module.start_warp()
starts = []
warp.init = slow
before = os.fstat(2)
barrier = threading.Barrier(2)
threads = [threading.Thread(target=start) for _ in range(2)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
assert os.path.samestat(os.fstat(2), before), "stderr is another file"
assert len(starts) == 1, starts
"""


def draw(tmp_path, **environment):
    """Draw in a new process; returns where the kernels went, after checking that nothing was said."""
    read, write = os.pipe()
    names = {k: v for k, v in os.environ.items() if k not in ("XDG_CACHE_HOME", "WARP_CACHE_PATH")}
    code = DRAW.replace("open(3,", f"open({write},")
    done = subprocess.run([sys.executable, "-c", code], env=names | environment, capture_output=True, pass_fds=[write])
    os.close(write)
    with os.fdopen(read) as pipe:
        folder = pipe.read()
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
    return folder


def test_is_quiet_and_keeps_kernels_in_the_users_cache(tmp_path):
    folder = draw(tmp_path, XDG_CACHE_HOME=str(tmp_path))
    assert folder.startswith(str(tmp_path / "caricli" / "warp"))
    assert any((tmp_path / "caricli" / "warp").rglob("*.o"))


def test_a_cache_that_cannot_be_written_is_no_obstacle(tmp_path):
    (tmp_path / "caricli").write_text("a file where the folder should be")
    folder = draw(tmp_path, XDG_CACHE_HOME=str(tmp_path))
    assert folder and not folder.startswith(str(tmp_path)) and not os.path.exists(folder)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_cache_is_no_obstacle(tmp_path):
    (tmp_path / "caricli" / "warp").mkdir(parents=True)
    (tmp_path / "caricli" / "warp").chmod(0o500)
    assert not draw(tmp_path, XDG_CACHE_HOME=str(tmp_path)).startswith(str(tmp_path))


def test_the_package_does_not_import_warp():
    modules = "caricli.render.views, caricli.render.sheets.overlay, caricli.commands.render"
    code = f"import sys, {modules}; sys.exit('warp' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_threads_that_start_it_at_once_leave_stderr_as_it_was(tmp_path):
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", AT_ONCE], env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
