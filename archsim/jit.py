"""The only door to numba: `njit` with a disk cache that notices edits in every source file.

Numba's own cache keys a function by its own file, so an edit to a callee elsewhere would go unseen, and it ignores
NUMBA_BOUNDSCHECK. Here the cache folder's name is a digest of every source file that compiled code can depend on, and
of that flag.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import platformdirs

_PACKAGE = Path(__file__).resolve().parent
_KEPT_CACHES = 8
_NEVER_COMPILED = {
    "config",
    "run",
    "report",
    "reproduce",
    "sweep",
    "cli",
}  # packages that compiled code cannot import


def code_digest(without: frozenset[str] | set[str] = frozenset()) -> str:
    """Digest of the package's Python source files: the identity of the code that produced a result.

    `without` names top-level packages to leave out.
    """
    digest = hashlib.sha256()
    for path in sorted(_PACKAGE.rglob("*.py")):
        place = path.relative_to(_PACKAGE)
        if place.parts[0] not in without:
            digest.update(place.as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _cache_folder() -> Path:
    """The folder for this code, made. Where it cannot be, a new temporary one: numba would choose one of its own."""
    root = Path(os.environ.get("ARCHSIM_CACHE_DIR") or platformdirs.user_cache_dir("archsim")) / "numba"
    flavour = os.environ.get("NUMBA_BOUNDSCHECK", "0")
    key = f"{code_digest(_NEVER_COMPILED)[:16]}-b{flavour}-py{sys.version_info.major}{sys.version_info.minor}"
    try:
        _forget_old(root, keep=key)
        (root / key).mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=root / key):
            return root / key
    except OSError:
        folder = tempfile.mkdtemp(prefix="archsim-numba-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        return Path(folder)


def _forget_old(root: Path, keep: str) -> None:
    """Remove all but the newest caches, so that edits do not fill the disk."""
    if not root.is_dir() or (root / keep).is_dir():
        return
    folders = sorted((f for f in root.iterdir() if f.is_dir()), key=lambda f: f.stat().st_mtime, reverse=True)
    for folder in folders[_KEPT_CACHES - 1 :]:
        shutil.rmtree(folder, ignore_errors=True)


os.environ["NUMBA_CACHE_DIR"] = str(_cache_folder())

import numba  # noqa: E402  (the cache folder must be known before numba is imported)
from llvmlite import ir  # noqa: E402
from numba.extending import intrinsic, overload  # noqa: E402

numba.config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"]  # type: ignore[attr-defined]  # if imported before us


def njit(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Compile in nopython mode with the disk cache on. IEEE arithmetic: no fastmath, no contraction."""
    options.setdefault("cache", True)
    if function is None:
        return lambda f: numba.njit(f, **options)
    return numba.njit(function, **options)


# For inner loops over states of many arrays: numba counts references to every array of every tuple that it passes
# around, which can cost far more than the work itself. Without its runtime (`_nrt`) there is nothing to count; such a
# function must not allocate an array, a slice assignment included. Division by zero follows IEEE, not Python.
compiled = njit(error_model="numpy", _nrt=False)
inlined = njit(error_model="numpy", _nrt=False, forceinline=True)


def num_bits(word: int) -> int:
    """Bits that are set in a number from 0 up; one instruction in compiled code."""
    return int(word).bit_count()


def lowest_bit(word: int) -> int:
    """Number of the lowest bit that is set in a number from 1 up; one instruction in compiled code."""
    return (int(word) & -int(word)).bit_length() - 1


def bit_length(word: int) -> int:
    """Bits from the lowest to the highest one that is set in a number from 0 up; two instructions in compiled code."""
    return int(word).bit_length()


@intrinsic
def _ctpop(_typing: Any, word: Any) -> Any:
    """LLVM's count of bits."""
    return numba.int64(numba.int64), lambda _context, builder, _signature, args: builder.ctpop(args[0])


@intrinsic
def _cttz(_typing: Any, word: Any) -> Any:
    """LLVM's count of trailing zeros."""

    def generate(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.cttz(args[0], ir.Constant(ir.IntType(1), 1))

    return numba.int64(numba.int64), generate


@intrinsic
def _ctlz(_typing: Any, word: Any) -> Any:
    """LLVM's count of leading zeros."""

    def generate(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.ctlz(args[0], ir.Constant(ir.IntType(1), 0))

    return numba.int64(numba.int64), generate


@overload(num_bits, inline="always")
def _num_bits(word):  # without types: numba wants the parameters of both to be alike
    return lambda word: _ctpop(word)  # type: ignore[call-arg]


@overload(lowest_bit, inline="always")
def _lowest_bit(word):
    return lambda word: _cttz(word)  # type: ignore[call-arg]


@overload(bit_length, inline="always")
def _bit_length(word):
    return lambda word: 64 - _ctlz(word)  # type: ignore[call-arg]
