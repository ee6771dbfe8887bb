"""The checkers of this folder find what they are for, and let pass what stands beside it."""

import pathlib
import subprocess

import pytest

TOOLS = pathlib.Path(__file__).resolve().parent


def run(checker: str, root: pathlib.Path, files: dict[str, str]) -> tuple[int, str]:
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    result = subprocess.run([TOOLS / checker, root], capture_output=True, text=True, check=False)
    assert result.stderr == ""
    return result.returncode, result.stdout


HEADERS = {
    "core/include/genphys/world.h": "#include <vector>\n#include <Eigen/Core>\n#include \"absl/status/status.h\"\n",
    "core/src/joints/joint_step.h": "",
    "wire/include/genphys/wire/decode.h": "",
    "backends/ode/include/genphys/backends/ode.h": "",
    "server/hosting/include/genphys/hosting/host.h": "",
    "server/services/include/genphys/services/world_service.h": "",
    "client/cpp/include/genphys/client/client.h": "",
    "tests/support/scenes.h": "",
    "bench/rpc/echo.h": "",
}


@pytest.mark.parametrize("path, line", [
    ("core/include/genphys/a.h", '#include "genphys/wire/decode.h"'),
    ("core/include/genphys/a.h", '#include "genphys/v1/types.pb.h"'),
    ("core/include/genphys/a.h", '#include "absl/strings/str_cat.h"'),
    ("core/include/genphys/a.h", "#include <xxhash.h>"),
    ("core/src/a.cc", "#include <thread>"),
    ("core/src/a.cc", "#include <ode/ode.h>"),
    ("core/src/a.cc", "#include <grpcpp/grpcpp.h>"),
    ("core/src/a.cc", "#include <google/protobuf/message.h>"),
    ("core/src/a.cc", '#include "genphys/no_such_header.h"'),
    ("core/src/shapes/a.cc", '#include "joints/joint_step.h"'),
    ("backends/ode/src/a.cc", '#include "genphys/wire/decode.h"'),
    ("backends/ode/src/a.cc", "#include <btBulletDynamicsCommon.h>"),
    ("backends/bullet/src/a.cc", '#include "genphys/backends/ode.h"'),
    ("backends/bullet/src/a.cc", "#include <ode/ode.h>"),
    ("wire/src/a.cc", '#include "genphys/backends/ode.h"'),
    ("wire/src/a.cc", '#include "genphys/hosting/host.h"'),
    ("wire/src/a.cc", '#include "../../server/hosting/include/genphys/hosting/host.h"'),
    ("wire/src/a.cc", "#include <grpcpp/grpcpp.h>"),
    ("server/hosting/src/a.cc", '#include "genphys/services/world_service.h"'),
    ("server/hosting/src/a.cc", "#include <grpcpp/grpcpp.h>"),
    ("server/services/src/a.cc", '#include "genphys/client/client.h"'),
    ("client/cpp/src/a.cc", '#include "genphys/hosting/host.h"'),
    ("bench/rpc/a.cc", '#include "support/scenes.h"'),
    ("tests/unit/a.cc", '#include "rpc/echo.h"'),
    ("examples/cpp/a.cc", '#include "genphys/hosting/host.h"'),
])
def test_layers_refuses_an_include_that_points_up_or_sideways(tmp_path, path, line):
    status, output = run("check_layers", tmp_path, HEADERS | {path: f"#pragma once\n{line}\n"})

    assert status == 1
    assert f"{path}:2: {line}: " in output
    assert "1 problem(s)" in output


@pytest.mark.parametrize("path, line", [
    ("core/include/genphys/a.h", '#include "genphys/world.h"'),
    ("core/src/a.cc", "#include <xxhash.h>"),
    ("core/src/a.cc", '#include "absl/strings/str_cat.h"'),
    ("core/src/joints/a.cc", '#include "joints/joint_step.h"'),
    ("core/src/step/a.cc", '#include "joints/joint_step.h"'),
    ("backends/ode/src/a.cc", "#include <ode/ode.h>"),
    ("backends/ode/src/a.cc", "#include <mutex>"),
    ("backends/bullet/src/a.cc", "#include <BulletCollision/CollisionShapes/btBoxShape.h>"),
    ("wire/src/a.cc", '#include "genphys/v1/types.pb.h"'),
    ("wire/src/a.cc", '#include "google/protobuf/message.h"'),
    ("server/hosting/src/a.cc", "#include <thread>"),
    ("server/services/src/a.cc", '#include "genphys/hosting/host.h"'),
    ("server/main.cc", '#include "genphys/services/world_service.h"'),
    ("client/cpp/src/a.cc", '#include "genphys/wire/decode.h"'),
    ("tests/unit/a.cc", '#include "support/scenes.h"'),
    ("tests/unit/a.cc", '#include "genphys/hosting/host.h"'),
    ("examples/cpp/a.cc", '#include "genphys/client/client.h"'),
])
def test_layers_accepts_an_include_that_points_down(tmp_path, path, line):
    status, output = run("check_layers", tmp_path, HEADERS | {path: f"{line}\n"})

    assert (status, output) == (0, "")


@pytest.mark.parametrize("path, limit", [("core/include/genphys/a.h", 300), ("core/src/a.cc", 500)])
def test_sizes_refuses_a_file_one_line_over_the_limit(tmp_path, path, limit):
    assert run("check_sizes", tmp_path, {path: "\n" * limit}) == (0, "")

    status, output = run("check_sizes", tmp_path, {path: "\n" * (limit + 1)})

    assert status == 1
    assert f"{path}: {limit + 1} lines, at most {limit}" in output


def function_of(lines: int) -> str:
    return "void F() {\n" + "  G();\n" * (lines - 2) + "}\n"


def test_sizes_refuses_a_function_one_line_over_the_limit(tmp_path):
    wrapped = "namespace genphys {\nnamespace {\n\n{}\n}  // namespace\n}  // namespace genphys\n"
    assert run("check_sizes", tmp_path, {"core/src/a.cc": wrapped.replace("{}", function_of(70))}) == (0, "")

    status, output = run("check_sizes", tmp_path, {"core/src/a.cc": wrapped.replace("{}", function_of(71))})

    assert status == 1
    assert "core/src/a.cc:4: a function of 71 lines" in output


def test_folders_refuses_one_that_nobody_explains(tmp_path):
    status, output = run("check_folders", tmp_path, {
        "docs/architecture.md": "* `core/` is the model.\n* `tests/` has `unit/`.\n* `server/`.\n* `hosting/`.\n",
        "core/src/a.cc": "",
        "core/include/genphys/a.h": "",
        "tests/unit/a.cc": "",
        "wire/README.md": "",
        "wire/src/a.cc": "",
        "server/hosting/src/a.cc": "",
    })

    assert status == 1
    assert output.startswith("server/hosting/: no README.md")
    assert "1 problem(s)" in output
