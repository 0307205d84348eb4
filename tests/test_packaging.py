"""What is shipped: package data, the wheel, the commands of the Makefile, and a README that tells the truth."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import archsim
from archsim import resources

ROOT = Path(archsim.__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
README = (ROOT / "README.md").read_text()


def test_every_top_level_folder_of_data_rides_in_the_wheel():
    shipped = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]

    assert shipped == {name: f"archsim/_packaged/{name}" for name in ("kernels", "configs", "experiments")}
    for name in shipped:
        assert (resources.root() / name).is_dir()


def test_the_package_works_outside_a_checkout(tmp_path):
    """The layout of an installed wheel, put together by hand."""
    site = tmp_path / "site-packages"
    shutil.copytree(ROOT / "archsim", site / "archsim", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("kernels", "configs", "experiments"):
        shutil.copytree(ROOT / name, site / "archsim" / "_packaged" / name)
    code = "import sys; sys.path.insert(0, sys.argv.pop(1)); from archsim.cli import main; main()"

    def run(*arguments):
        command = [sys.executable, "-c", code, str(site), *arguments]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout

    assert run("config", "check", "tiny") == "tiny: ok\n"
    assert "izb_build: 40 instructions" in run("asm", "izb_build")


@pytest.mark.parametrize("target", ["reproduce", "test", "test-slow", "lint", "docs", "clean"])
def test_make_knows_the_targets(target):
    planned = subprocess.run(["make", "-n", target], cwd=ROOT, capture_output=True, text=True, check=False)

    assert planned.returncode == 0, planned.stderr


def test_make_says_when_python_is_too_old(tmp_path):
    old = tmp_path / "python3.8"
    old.write_text("#!/bin/sh\nexit 1\n")
    old.chmod(0o755)
    for name in ("Makefile", "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path)

    made = subprocess.run(
        ["make", "lint", f"PYTHON={old}"], cwd=tmp_path, capture_output=True, text=True, check=False
    )

    assert made.returncode != 0
    assert "needs Python 3.11 or newer" in made.stdout
    assert not (tmp_path / ".venv").exists()


def test_ci_is_a_script_that_calls_make_test():
    script = ROOT / ".ci" / "run"

    assert os.access(script, os.X_OK)
    assert "make test" in script.read_text()
    subprocess.run(["bash", "-n", script], check=True)


def test_the_first_screen_has_the_two_commands():
    first_screen = "\n".join(README.splitlines()[:40])

    assert "make reproduce" in first_screen
    assert "make test" in first_screen


def test_the_readme_shows_the_teaching_machine_in_full():
    assert resources.config("machines", "tiny").read_text().strip() in README


def consoles() -> list[tuple[str, str]]:
    """(command, output) of every console block of the README."""
    blocks = re.findall(r"```console\n(.*?)```", README, re.DOTALL)
    return [tuple(block.removeprefix("$ ").split("\n", 1)) for block in blocks]


@pytest.mark.parametrize(("command", "output"), consoles(), ids=[command for command, _ in consoles()])
def test_the_outputs_in_the_readme_are_real(tmp_path, command, output):
    words = shlex.split(command)
    assert words[0] == "archsim"
    program = Path(sys.executable).with_name("archsim")

    done = subprocess.run(
        [program, *words[1:]],
        cwd=tmp_path,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )

    assert [line.rstrip() for line in done.stdout.splitlines()] == output.splitlines()


def test_links_in_the_readme_lead_somewhere():
    links = re.findall(r"\]\(([^)#]+)\)", README)

    assert links
    for link in links:
        assert (ROOT / link).exists(), link
