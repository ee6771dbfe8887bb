"""Tests of what peers have in common. None needs an engine."""

import json
import pathlib
import subprocess
import sys

import joint_tree
import protocol
import pytest

HERE = pathlib.Path(__file__).resolve().parent
STILL = {"orientation": [1, 0, 0, 0], "spin": [0, 0, 0], "velocity": [0, 0, 0]}


def ball(**more):
    return {"shape": {"kind": "sphere", "radius": 0.1}, "position": [0, 0, 0], "mass": 2,
            "tensor": [0.008, 0.008, 0.008, 0, 0, 0], **STILL, **more}


def scene(*bodies, joints=(), ground=False):
    return {"gravity": [0, 0, -9.81], "ground": ground, "friction": 0, "restitution": 0, "bodies": list(bodies),
            "joints": list(joints)}


def joint(a, b, kind="ball"):
    return {"kind": kind, "a": a, "b": b, "in_a": {"position": [0, 0, 0], "orientation": [1, 0, 0, 0]},
            "in_b": {"position": [0, 0, 0], "orientation": [1, 0, 0, 0]}}


def answers(command, requests):
    lines = "".join(json.dumps(request) + "\n" for request in requests)
    done = subprocess.run(command, input=lines, capture_output=True, text=True, check=True, timeout=60)
    return done.stdout.splitlines()


def euler(*requests):
    return answers([sys.executable, HERE / "euler_peer.py"], requests)


# As euler_peer.py, but that it only falls, and so does whoever is told of it.
FALLING = f"""
import {{ Refused, World, serve }} from "{(HERE / 'protocol.mjs').as_uri()}";
class Falling extends World {{
  constructor(scene) {{
    super();
    if (scene.ground) throw new Refused("contacts");
    [this.z, this.v, this.g] = [0, 0, scene.gravity[2]];
  }}
  step(size, count) {{
    for (let i = 0; i < count; ++i) {{ this.v += size * this.g; this.z += size * this.v; }}
  }}
  state() {{ return [0, 0, this.z, 1, 0, 0, 0, 0, 0, this.v, 0, 0, 0]; }}
}}
console.log("an engine greets");
serve({{ name: "Falling", version: "1", settings: "" }}, (scene) => new Falling(scene));
"""


def falling(*requests):
    return answers(["node", "--input-type=module", "--eval", FALLING], requests)


@pytest.mark.parametrize("peer", [euler, falling])
def test_a_peer_falls_as_it_does_and_says_only_what_is_asked(peer):
    about, started, state = peer(["about"], ["start", scene(ball())], ["step", 0.01, 60], ["step", 0.01, 40], ["state"])
    numbers = [float(word) for word in state.split()[1:]]
    assert json.loads(about.removeprefix("ok "))["version"] == "1"
    assert (started, state.split()[0], len(numbers)) == ("ok", "ok", 13)
    # Semi-implicit Euler is behind by half a step's change of velocity.
    assert abs(numbers[2] + 9.81 / 2 + 9.81 * 0.01 / 2) < 1e-12 and abs(numbers[9] + 9.81) < 1e-12


@pytest.mark.parametrize("peer", [euler, falling])
def test_a_failure_is_told_with_the_next_answer_and_until_the_next_start(peer):
    assert peer(["start", scene(ball())], ["release", 0], ["step", 0.01, 1], ["state"], ["time", 0.01, 1],
                ["start", scene(ball(), ground=True)], ["state"], ["start", scene(ball())], ["state"])[:-1] == [
        "ok", "no joints that are removed", "no joints that are removed", "no contacts", "no contacts", "ok"]


@pytest.mark.parametrize("peer", [euler, falling])
def test_time_is_that_of_steps(peer):
    few, many = (float(line.split()[1]) for line in peer(
        ["start", scene(ball())], ["time", 0.01, 1], ["time", 0.01, 100_000])[1:])
    assert 0 <= few < many < 20


def test_who_is_too_slow_is_told_so(monkeypatch):
    class Slow(protocol.World):
        def step(self, size, count):
            clock.append(clock[-1] + count)

    clock = [0.0]
    monkeypatch.setattr(protocol.time, "process_time", lambda: clock[-1])
    assert protocol.run(Slow(), 0.01, 20) == 20
    with pytest.raises(protocol.Refused, match="slow"):
        protocol.run(Slow(), 0.01, 1000)
    assert clock[-1] < 60


def test_what_an_adapter_leaves_out_is_refused():
    world = protocol.World()
    for verb in (lambda: world.hold(0, 0, 0, 0, 0, 0, 0), lambda: world.kick(0, 0, 0, 0),
                 lambda: world.gravity(0, 0, 0), lambda: world.remove(0), lambda: world.release(0)):
        with pytest.raises(protocol.Refused):
            verb()
    with pytest.raises(protocol.Refused, match="restitution"):
        protocol.refuse_restitution(scene() | {"restitution": 0.5})


def test_links_come_after_what_they_hang_on():
    chain = joint_tree.links(scene(ball(), ball(), ball(), ball(mass=None), joints=[joint(2, 1), joint(None, 2)]))
    assert [(link.body, link.parent) for link in chain] == [(2, None), (1, 2), (0, None)]
    assert [link.joint is None for link in chain] == [False, False, True]


def test_what_hangs_on_a_free_body_goes_with_it():
    pair = joint_tree.links(scene(ball(), ball(), joints=[joint(1, 0)]))
    assert [(link.body, link.parent, link.joint is None) for link in pair] == [(0, None, True), (1, 0, False)]


@pytest.mark.parametrize("joints", [[joint(None, 0), joint(0, 1), joint(None, 1)], [joint(0, 1), joint(0, 1)],
                                    [joint(None, 0), joint(None, 0)]])
def test_loops_are_refused(joints):
    with pytest.raises(protocol.Refused, match="loops"):
        joint_tree.links(scene(ball(), ball(), joints=joints))


def test_a_frame_is_told_in_another():
    half = 0.5**0.5
    near = {"position": [1, 2, 3], "orientation": [half, 0, 0, half]}
    position, turn = joint_tree.local(near, {"position": [1, 5, 3], "orientation": [half, 0, 0, half]})
    assert position == pytest.approx([3, 0, 0]) and turn == pytest.approx([1, 0, 0, 0])
    assert joint_tree.rotate(joint_tree.upright([0.6, 0, 0.8]), [0, 0, 1]) == pytest.approx([0.6, 0, 0.8])
    assert joint_tree.rotate(joint_tree.upright([0, 0, -1]), [0, 0, 1]) == pytest.approx([0, 0, -1])
