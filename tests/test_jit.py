"""The disk cache of compiled code: never stale, never in the source tree."""

import subprocess
import sys
from pathlib import Path

import pytest

from archsim import jit


def cache_folder(**environment):
    """The cache folder that a new process chooses."""
    code = "import archsim.jit, os; print(os.environ['NUMBA_CACHE_DIR'])"
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    return Path(done.stdout.strip())


def test_the_digest_notices_an_edit_of_any_file_that_compiled_code_can_depend_on(tmp_path, monkeypatch):
    (tmp_path / "raster").mkdir()
    (tmp_path / "cli").mkdir()
    files = [tmp_path / "raster" / "edges.py", tmp_path / "cli" / "run.py"]
    for file in files:
        file.write_text("one = 1")
    monkeypatch.setattr(jit, "_PACKAGE", tmp_path)
    whole, compiled = jit.code_digest(), jit.code_digest({"cli"})

    files[1].write_text("one = 2")
    assert jit.code_digest() != whole
    assert jit.code_digest({"cli"}) == compiled
    files[0].write_text("one = 2")
    assert jit.code_digest({"cli"}) != compiled


def test_bounds_checked_code_has_a_cache_of_its_own(tmp_path):
    plain = cache_folder(ARCHSIM_CACHE_DIR=str(tmp_path))
    checked = cache_folder(ARCHSIM_CACHE_DIR=str(tmp_path), NUMBA_BOUNDSCHECK="1")
    assert plain != checked
    assert plain.parent == checked.parent == tmp_path / "numba"


def test_an_unusable_cache_folder_is_replaced_by_a_temporary_one(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    folder = cache_folder(ARCHSIM_CACHE_DIR=str(tmp_path / "file"))
    assert folder.name.startswith("archsim-numba-")
    assert not folder.exists(), "removed at the end of the process"


@pytest.mark.parametrize("number", [3, 20])
def test_old_caches_are_removed(tmp_path, number):
    for k in range(number):
        (tmp_path / str(k)).mkdir()
    jit._forget_old(tmp_path, keep="new")
    assert len(list(tmp_path.iterdir())) == min(number, jit._KEPT_CACHES - 1)
