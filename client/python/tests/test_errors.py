"""A failed call becomes the exception of its reason, and never a bare grpc.RpcError."""

import time

import grpc
import pytest
from fake_server import FakeServer, refuse

import genphys
from genphys import errors, joints
from genphys._contract import enum_names, wire

REASONS = sorted(enum_names("ErrorReason", "ERROR_REASON_").values())

SHORT_SECONDS = 0.2
PATIENCE_SECONDS = 10.0
# gRPC sends a deadline in coarse units, rounded up; the way to the server takes some of it, but never half.
ROUNDED_UP = 1.05


def refusing(code, reason, message, field=""):
    return FakeServer(GetWorld=lambda request, context: refuse(context, code, reason, message, field))


def error_of(server):
    with genphys.connect(server.address) as client, pytest.raises(genphys.GenphysError) as caught:
        client.world("lab").info()
    return caught.value


@pytest.mark.parametrize("reason", [reason.upper() for reason in REASONS])
def test_every_reason_of_the_contract_has_an_exception_of_its_own(reason):
    with refusing(grpc.StatusCode.INVALID_ARGUMENT, reason, "no") as server:
        error = error_of(server)

    assert type(error) is errors.BY_REASON[reason]
    assert type(error) is not genphys.GenphysError
    assert getattr(genphys, type(error).__name__) is type(error)
    assert error.reason == reason


def test_no_exception_has_a_reason_that_the_contract_lacks():
    assert sorted(errors.BY_REASON) == [reason.upper() for reason in REASONS]


def test_a_refusal_tells_code_message_field_and_metadata():
    with refusing(grpc.StatusCode.INVALID_ARGUMENT, "NOT_FINITE", "NaN is no force", "force.force.x") as server:
        error = error_of(server)

    assert isinstance(error, genphys.NotFiniteError)
    assert error.code is grpc.StatusCode.INVALID_ARGUMENT
    assert error.message == "NaN is no force"
    assert error.field == "force.force.x"
    assert error.metadata == {"engine": "ode"}
    assert str(error) == "NaN is no force [NOT_FINITE at force.force.x]"


def test_what_a_step_that_ended_early_created_has_ids():
    early_end = {"steps_done": 3, "step": 8, "created_ids": [7, 0, 9, 10, 11, 12]}
    refusal = {"code": grpc.StatusCode.DEADLINE_EXCEEDED.value[0], "message": "late", "early_end": early_end}
    result = {"index": 0, "refusal": refusal}

    def answer(request, context):
        yield wire.StepWorldsResponse(results=[result])

    with FakeServer(StepWorlds=answer) as server, genphys.connect(server.address) as client:
        world = client.world("lab")
        with world.batch() as batch:
            first = batch.add_sphere(name="first")
            batch.set_gravity((0, 0, 0))
            others = [batch.add_sphere() for _ in range(3)]
            joint = batch.join(first, others[0], joints.Fixed())
        (error,) = client.step_worlds([world], 10)

    assert isinstance(error, genphys.DeadlineExceededError)
    assert error.metadata == {"steps_done": "3", "step": "8", "created_ids": "0:7 2:9-12"}
    assert [each.id for each in (first, *others, joint)] == [7, 9, 10, 11, 12]


def test_how_many_commands_were_carried_out_is_told():
    refusal = {"message": "late", "early_end": {"step": 8, "commands_done": 0}}

    def answer(request, context):
        yield wire.StepWorldsResponse(results=[{"index": 0, "refusal": refusal}])

    with FakeServer(StepWorlds=answer) as server, genphys.connect(server.address) as client:
        (error,) = client.step_worlds([client.world("lab")], 10)

    assert error.metadata == {"steps_done": "0", "step": "8", "commands_done": "0"}


def test_a_reason_of_a_newer_server_is_still_a_genphys_error():
    with refusing(grpc.StatusCode.FAILED_PRECONDITION, "MOON_IS_FULL", "wait") as server:
        error = error_of(server)

    assert type(error) is genphys.GenphysError
    assert error.reason == "MOON_IS_FULL"


def test_a_status_without_details_is_a_genphys_error():
    with FakeServer(GetWorld=lambda request, context: context.abort(grpc.StatusCode.INTERNAL, "oops")) as server:
        error = error_of(server)

    assert type(error) is genphys.GenphysError
    assert (error.code, error.message, error.reason, error.field) == (grpc.StatusCode.INTERNAL, "oops", "", "")


def test_a_call_ends_at_its_timeout():
    def late(request, context):
        time.sleep(2 * SHORT_SECONDS)
        return wire.GetWorldResponse()

    with FakeServer(GetWorld=late) as server, genphys.connect(server.address) as client:
        world = client.world("lab")
        with pytest.raises(genphys.DeadlineExceededError):
            world.info(timeout=SHORT_SECONDS)
        assert world.info(timeout=PATIENCE_SECONDS).state == "0"


def test_every_unary_call_has_the_deadline_of_its_connection_unless_told_otherwise():
    left = []

    def measure(request, context):
        left.append(context.time_remaining())
        return wire.GetWorldResponse()

    with FakeServer(GetWorld=measure) as server, genphys.connect(server.address) as client:
        world = client.world("lab")
        world.info()
        world.info(timeout=PATIENCE_SECONDS)
        world.info(timeout=float("inf"))

    assert genphys.DEFAULT_TIMEOUT_SECONDS / 2 < left[0] <= genphys.DEFAULT_TIMEOUT_SECONDS * ROUNDED_UP
    assert PATIENCE_SECONDS / 2 < left[1] <= PATIENCE_SECONDS * ROUNDED_UP
    assert left[2] is None or left[2] > 1e6


def test_nobody_at_the_address_is_said_with_the_way_out():
    with FakeServer() as server:
        address = server.address

    with pytest.raises(genphys.UnavailableError, match="genphysd --listen"):
        genphys.connect(address)


@pytest.mark.parametrize("no_address", ["127.0.0.1", "http://127.0.0.1:50051"])
def test_what_is_no_address_is_told_how_to_write_one(no_address):
    with pytest.raises(genphys.UnavailableError, match="write host:port, as in 127.0.0.1:50051"):
        genphys.connect(no_address, timeout=5)


def test_a_closed_connection_refuses_to_call():
    with FakeServer() as server:
        client = genphys.connect(server.address)
        client.close()
        client.close()
        with pytest.raises(genphys.CancelledError, match="closed"):
            client.engines()


def owning(delete):
    return FakeServer(
        CreateWorld=lambda request, context: wire.CreateWorldResponse(world={"name": "worlds/lab"}), DeleteWorld=delete
    )


def test_a_world_that_somebody_else_deleted_ends_its_block_in_peace():
    def gone(request, context):
        refuse(context, grpc.StatusCode.NOT_FOUND, "WORLD_NOT_FOUND", "gone")

    with owning(gone) as server, genphys.connect(server.address) as client:
        with client.create_world():
            pass
        assert len(server.received("DeleteWorld")) == 1


def test_a_failing_end_of_a_world_hides_no_earlier_error():
    def broken(request, context):
        context.abort(grpc.StatusCode.UNAVAILABLE, "the server is gone")

    with owning(broken) as server, genphys.connect(server.address) as client:
        with pytest.raises(ZeroDivisionError), client.create_world():
            1 / 0  # noqa: B018
        with pytest.raises(genphys.UnavailableError), client.create_world():
            pass
        with pytest.raises(ZeroDivisionError), client.world("lab"):
            1 / 0  # noqa: B018
        assert len(server.received("DeleteWorld")) == 2
