"""What a user reads in errors are the names of this package, whatever the contract calls it."""

import dataclasses
import inspect
import re

import grpc
import pytest
from fake_server import FakeServer, refuse

import genphys
from genphys import _encode, _naming, fields, joints, model
from genphys._contract import METHODS, wire
from genphys.commands import Commands

CALLS = {
    "ApplyForceRequest": genphys.World.apply_force,
    "CastRaysRequest": genphys.World.cast_rays,
    "CastShapeRequest": genphys.World.cast_shape,
    "CreateEntityRequest": genphys.World.add_entity,
    "CreateWorldRequest": genphys.Server.create_world,
    "DriveRequest": genphys.Drive.send,
    "FindClosestRequest": genphys.World.find_closest,
    "FindOverlapsRequest": genphys.World.find_overlaps,
    "GetContactsRequest": genphys.World.contacts_of,
    "GetEntityRequest": genphys.World.entity,
    "MeasureDistancesRequest": genphys.World.distances,
    "PlayWorldRequest": genphys.World.play,
    "StepRequest": genphys.World.step,
    "WatchEventsRequest": genphys.World.events,
    "WatchFramesRequest": genphys.World.frames,
}
NOT_OFFERED = re.compile(
    r"(.*\.)?(request_id|keyframe_id)"
    r"|CastRaysRequest\.all_hits"  # a call of its own
    r"|CreateWorldRequest\.world\.state"
    r"|.*\b(create_\w+|CreateEntityRequest)\.(entity|joint|field)\.id"
    r"|.*\bupdate_joint\.joint\.entity_[ab](\.\w+)?"
)
WORLD = {"world"}  # that is what the method is called on
VALUES = {
    field.name
    for module in (model, joints, fields)
    for kind in vars(module).values()
    if dataclasses.is_dataclass(kind)
    for field in dataclasses.fields(kind)
}
OF_ARRAYS = {"flat", "shape"}


def paths_below(message, path=""):
    for field in message.fields:
        here = f"{path}{field.name}" + ("[0]" if field.label == field.LABEL_REPEATED else "")
        yield here
        if field.message_type is not None:
            yield from paths_below(field.message_type, f"{here}.")
    for oneof in message.oneofs:
        if not oneof.name.startswith("_"):
            yield f"{path}{oneof.name}"


def keywords(call):
    named = set(inspect.signature(call).parameters)
    return named | (_encode.ENTITY_KEYWORDS if "options" in named else set())


def unknown_words(message, path):
    """What a user reads of a path and never wrote."""
    parts = [re.sub(r"\[\d+\]", "", part) for part in _naming.parts_of(message, path)]
    call = CALLS[message.name]
    if parts[:1] == ["commands"]:
        call = getattr(Commands, parts[1]) if len(parts) > 1 else None
        parts = parts[2:]
    first, *rest = ".".join(parts).split(".")
    known = {""} | WORLD | (keywords(call) if call is not None else set())
    return ({first} - known) | (set(rest) - VALUES - OF_ARRAYS - {"position", "orientation"})


@pytest.mark.parametrize("name", CALLS)
def test_every_field_of_the_contract_is_told_as_what_the_user_wrote(name):
    message = getattr(wire, name).DESCRIPTOR
    for path in paths_below(message):
        if not NOT_OFFERED.fullmatch(f"{name}.{path}"):
            assert unknown_words(message, path) == set(), path


def test_no_request_that_has_more_than_the_name_of_a_world_is_left_out():
    of_names = {"DeleteWorldRequest", "GetEngineRequest", "GetWorldRequest", "PauseWorldRequest", "ResetWorldRequest"}
    requests = {each.request.DESCRIPTOR.name for each in METHODS.values()}
    of_pages = {name for name in requests if name.startswith("List")}

    assert requests - of_names - of_pages - CALLS.keys() == {"DeleteEntityRequest", "StepWorldsRequest"}


TOLD = {
    "entity.pose.position.y": "position[1]",
    "entity.pose.orientation.w": "orientation[0]",
    "entity.rigid_body.inertia.tensor[4]": "inertia_tensor",
    "entity.rigid_body.geometries[2].shape.box.half_extents.z": "geometries[2].shape.half_extents[2]",
    "entity.rigid_body.geometries[2].shape.convex_hull.vertices[7]": "geometries[2].shape.vertices[2][1]",
    "entity.rigid_body.geometries[0].shape.heightfield.heights[9]": "geometries[0].shape.heights.flat[9]",
    "entity.rigid_body.geometries[0].shape.kind": "geometries[0].shape",
}


@pytest.mark.parametrize("path", TOLD)
def test_a_path_leads_to_what_is_in_the_argument(path):
    assert ".".join(_naming.parts_of(wire.CreateEntityRequest.DESCRIPTOR, path)) == TOLD[path]


TOLD_OF_STEPS = {
    "steps": "steps",
    "events.entity_ids[3]": "events.entities[3]",
    "frame.scalar": "frame.dtype",
    "commands[3].set_pose.pose.position.x": "commands[3].set_pose.position[0]",
    "commands[0].apply_forces.forces[2].z": "commands[0].apply_forces.forces[2][2]",
    "commands[0].set_motors.targets[2]": "commands[0].set_motors.velocities[2]",
    "commands[0].create_joint.joint.hinge.motor.torque_max": "commands[0].join.kind.motor.force_max",
    "commands[0].create_joint.joint.ball.twist.upper_radians": "commands[0].join.kind.twist_upper",
    "commands[0].create_joint.joint.entity_a.id": "commands[0].join.entity_a",
    "commands[0].create_force_field.field.spring.entity_b": "commands[0].add_field.field.b",
    "commands[0].update_force_field.field.region.opposite_corner.y": "commands[0].update_field.region[1][1]",
    "commands[0].delete_entity.entity_id": "commands[0].remove.entity",
}


@pytest.mark.parametrize("path", TOLD_OF_STEPS)
def test_a_path_of_a_step_names_the_verb(path):
    assert ".".join(_naming.parts_of(wire.StepRequest.DESCRIPTOR, path)) == TOLD_OF_STEPS[path]


@pytest.mark.parametrize("path", ["steps.x", "moon", "entity.moon", "commands[0].apply_force.force.w", "a..b", "-"])
def test_a_path_that_the_contract_does_not_have_is_none(path):
    assert _naming.parts_of(wire.StepRequest.DESCRIPTOR, path) is None


def error_of(message, field, call):
    def no(request, context):
        refuse(context, grpc.StatusCode.INVALID_ARGUMENT, "OUT_OF_RANGE", message, field)

    with FakeServer(Step=no, CreateEntity=no, CreateWorld=no) as server, genphys.connect(server.address) as client:
        with pytest.raises(genphys.OutOfRangeError) as caught:
            call(client.world("lab"))
    return caught.value


def test_who_gives_one_command_alone_is_told_of_its_arguments():
    error = error_of("no", "commands[0].apply_force.force.x", lambda world: world.apply_force(5, (1, 2, 3)))

    assert error.argument == "force[0]"
    assert error.field == "commands[0].apply_force.force.x"
    assert str(error) == "no [OUT_OF_RANGE at force[0]]"


def test_who_adds_a_shape_is_told_of_the_shape_and_who_adds_geometries_of_these():
    radius, whole = "entity.rigid_body.geometries[0].shape.sphere.radius", "entity.rigid_body.geometries[0].shape"
    sphere = genphys.Geometry(shape=genphys.Sphere(0))

    assert error_of("no", radius, lambda world: world.add_sphere(radius=0)).argument == "radius"
    assert error_of("no", whole, lambda world: world.add_sphere(radius=0)).argument == ""
    error = error_of("no", radius, lambda world: world.add_entity(geometries=[sphere]))
    assert error.argument == "geometries[0].shape.radius"


def test_who_steps_a_batch_is_told_which_command():
    path = "create_entity.entity.rigid_body.geometries[0].shape.sphere.radius"
    sphere = genphys.Geometry(shape=genphys.Sphere(0))

    def step(world):
        for _ in range(2):
            with world.batch() as batch:
                batch.add_sphere(radius=0)
                batch.add_entity(geometries=[sphere])
        world.step()

    assert error_of("no", f"commands[2].{path}", step).argument == "commands[2].add_sphere.radius"
    error = error_of("no", f"commands[3].{path}", step)
    assert error.argument == "commands[3].add_entity.geometries[0].shape.radius"


@pytest.mark.parametrize(
    ("field", "message", "told"),
    [
        ("world.name", 'must have the form worlds/[a-z]*, is "worlds/a b"', 'must have the form [a-z]*, is "a b"'),
        ("entity.rigid_body.inertia.mass", "it needs inertia.mass", "it needs mass"),
        ("entity.rigid_body.inertia.tensor", "the tensor is none", "the tensor is none"),
        ("commands[0].set_motors.targets", "targets has more rows than joint_ids", "velocities has more rows than of"),
        ("commands[0].apply_force.entity_id", "commands[0].apply_force.entity_id is not set", "entity is not set"),
        ("", "listens at unix:/tmp/worlds/x for entity_id", "listens at unix:/tmp/worlds/x for entity_id"),
    ],
)
def test_what_a_server_says_has_the_names_of_the_user(field, message, told):
    call = {"w": lambda world: world._connection.call("CreateWorld", wire.CreateWorldRequest())}.get(field[:1])
    call = call or (lambda world: world.add_sphere() if field.startswith("entity") else world.set_gravity((0, 0, 0)))

    assert error_of(message, field, call).message == told
