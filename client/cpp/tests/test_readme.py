"""The program of one's own that the README shows, built from its very lines."""

import os
import pathlib
import re
import subprocess

_ROOT = pathlib.Path(__file__).resolve().parents[3]


def _block(language, first_line):
    """The code block of the README that begins with `first_line`."""
    page = (_ROOT / "client" / "cpp" / "README.md").read_text()
    return re.search(rf"```{language}\n({re.escape(first_line)}.*?)```", page, re.DOTALL).group(1)


def _run(command, folder, **options):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=280, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_program_of_ones_own_is_built_and_falls(tmp_path):
    (tmp_path / "CMakeLists.txt").write_text(_block("cmake", "cmake_minimum_required"))
    (tmp_path / "main.cc").write_text(_block("cpp", "// main.cc"))
    (tmp_path / "genphys").symlink_to(_ROOT)
    _, build_line, _ = _block("sh", "genphys/script/bootstrap").splitlines()
    configure = build_line.split("&&")[0]

    _run(configure, tmp_path, shell=True)

    build = tmp_path / "build"
    _run(["ninja", "CMakeFiles/falling_ball.dir/main.cc.o"], build)
    # Its libraries are those of this build, which takes minutes.
    link = _run(["ninja", "-t", "commands", "falling_ball"], build).splitlines()[-1]
    libraries = re.findall(r"genphys/(\S+\.a)", link)
    assert len(libraries) >= 4
    for library in libraries:
        place = build / "genphys" / library
        place.parent.mkdir(parents=True, exist_ok=True)
        place.symlink_to(pathlib.Path(os.environ["GENPHYS_BUILD_DIR"]) / library)
    _run(link, build, shell=True)

    run = ["bash", "-c", 'exec "$0" "$2"', str(build / "falling_ball")]
    said = _run([str(_ROOT / "script" / "with-server"), os.environ["GENPHYS_SERVER"], *run], tmp_path)
    assert said == "after half a second at 3.77 m\n"
