"""A server: its engines and its worlds."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import grpc

from . import _decode, _encode, model
from ._arguments import instance, items, text
from ._closing import Closing
from ._connection import DEFAULT_TIMEOUT_SECONDS, Connection, finish
from ._contract import make, wire
from ._launcher import ServerProcess, find_server
from .errors import GenphysError, UnavailableError, from_refusal, from_rpc_error
from .frame import StepResult
from .model import EngineInfo, Vector, WorldInfo
from .world import World

_PAGE_SIZE = 1000


class Server(Closing):
    """A connection to one server; ends it too if `launch` started it. Use it in a `with`, or call `close()`."""

    def __init__(self, connection: Connection, process: ServerProcess | None = None) -> None:
        self._connection = connection
        self._process = process

    @property
    def address(self) -> str:
        """Where it is, in gRPC's notation."""
        return self._connection.address

    def __repr__(self) -> str:
        return f"<Server {self.address}>"

    def close(self) -> None:
        """Closes the connection, and ends the server if `launch` started it. May be called again."""
        self._connection.close()
        if self._process is not None:
            self._process.end()

    def engines(self, *, timeout: float | None = None) -> list[EngineInfo]:
        """Returns the physics engines of this server and what each can do, in order of name."""
        found: list[EngineInfo] = []
        request = wire.ListEnginesRequest(page_size=_PAGE_SIZE)
        while True:
            response = self._connection.call("ListEngines", request, timeout)
            found += [_decode.engine_info(each) for each in response.engines]
            if not response.next_page_token:
                return found
            request.page_token = response.next_page_token

    def create_world(
        self,
        *,
        name: str = "",
        engine: str | None = None,
        gravity: Vector | None = None,
        ground_plane: bool | None = None,
        step_size: float | None = None,
        quality: str | None = None,
        solver: str | None = None,
        substeps: int | None = None,
        iterations: int | None = None,
        engine_only: bool = False,
        friction: float | None = None,
        kinetic_friction: float | None = None,
        restitution: float | None = None,
        density: float | None = None,
        friction_mixing: str | None = None,
        restitution_mixing: str | None = None,
        rolling_friction: float | None = None,
        spinning_friction: float | None = None,
        auto_disable: model.AutoDisable | None = None,
        error_correction: model.ErrorCorrection | None = None,
        recorded_events: model.EventKinds | None = None,
        record_state_hash: bool = False,
        required_features: Iterable[str] = (),
        timeout: float | None = None,
    ) -> World:
        """Makes a world; used in a `with`, it is deleted at the end of it. None leaves a value to the server.

        Args:
            name: As in "lab"; empty: the server finds one.
            engine: As in "ode"; None is the server's default; "none": nothing moves until one is set.
            gravity: m/s^2; None is (0, 0, -9.80665).
            ground_plane: Whether there is an infinite floor at z = 0; None is yes.
            step_size: Seconds of one step; None is 1/60.
            quality: "fast", "balanced" or "accurate": a preset of the next three.
            solver: "iterative" or "direct".
            substeps: Equal parts of a step.
            iterations: Sweeps of an iterative solver in each of them.
            engine_only: Bodies that fly with nothing near go through the engine too: slower, to compare.
            friction: Coulomb coefficient at rest, of geometries that leave it unset; so are the next seven.
            kinetic_friction: Coulomb coefficient while sliding.
            restitution: Speed of separation over speed of approach, 0 to 1.
            density: kg/m^3.
            friction_mixing: How coefficients of friction of two sides become one: see `Geometry`.
            restitution_mixing: The same for restitution.
            rolling_friction: Largest torque against rolling over the normal force, metres.
            spinning_friction: The same against spinning.
            auto_disable: When resting entities fall asleep.
            error_correction: How overlaps and the gaps of joints are taken away.
            recorded_events: Which kinds of events happen at all.
            record_state_hash: Put a hash of the state into every stamp.
            required_features: Fail unless the engine has all of these, as in "shape_box"; with "none" an engine is
                refused that lacks one when it is set.
            timeout: Seconds.

        Raises:
            AlreadyExistsError: a world has this name.
            UnsupportedFeatureError: the engine lacks a required feature.
            GenphysError: something else was refused; `field` says what.
        """
        defaults = wire.WorldDefaults(
            material=_encode.material(
                friction=friction,
                kinetic_friction=kinetic_friction,
                restitution=restitution,
                density=density,
                friction_mixing=friction_mixing,
                restitution_mixing=restitution_mixing,
                rolling_friction=rolling_friction,
                spinning_friction=spinning_friction,
            ),
            auto_disable=_encode.sleep_policy(auto_disable),
            error_correction=_encode.correction_policy(error_correction),
        )
        kinds = None if recorded_events is None else _encode.event_kinds(recorded_events, "recorded_events")
        description = make.World(
            name="" if name in (None, "") else _encode.resource("worlds", name, "name"),
            engine="" if engine in (None, "") else _encode.resource("engines", engine, "engine"),
            gravity=None if gravity is None else _encode.vector(gravity, "gravity"),
            stepper=_encode.stepper(step_size, quality, solver, substeps, iterations, engine_only),
            defaults=defaults,
            ground_plane=ground_plane,
            recorded_events=kinds,
            record_state_hash=record_state_hash,
            required_features=_encode.features(required_features),
        )
        response = self._connection.call("CreateWorld", wire.CreateWorldRequest(world=description), timeout)
        world = World(self._connection, response.world.name, owned=True)
        world.learn_names()
        return world

    def world(self, name: str) -> World:
        """Joins a world that exists; it is left alone at the end of a `with`.

        Raises:
            WorldNotFoundError: there is none of this name.
        """
        world = World(self._connection, _encode.resource("worlds", name, "name"), owned=False)
        world.learn_names()
        return world

    def step_worlds(
        self,
        worlds: Sequence[World],
        steps: int = 1,
        *,
        frame: bool | model.FrameRequest = True,
        events: bool | model.EventFilter = True,
        stats: bool = False,
        step_size: float | None = None,
        timeout: float | None = None,
    ) -> list[StepResult | GenphysError]:
        """Steps many worlds in one call, in parallel on the server, each with the commands collected for it.

        Returns, in the order of `worlds`, what `World.step` would have returned, or in its place the exception that it
        would have raised: none of them harms the others. The arguments are those of `World.step`.

        Raises:
            ValueError: a world is at another address than this server.
        """
        worlds = [
            instance(world, World, f"worlds[{index}]") for index, world in enumerate(items(worlds, "worlds"))
        ]
        for index, world in enumerate(worlds):
            # There may be one of the same name here.
            if world._connection.address != self.address:
                raise ValueError(f"worlds[{index}] is at {world._connection.address}, not at {self.address}")
        requests = [
            world._step_request(
                steps, frame=frame, events=events, stats=stats, step_size=step_size, expected_step=None
            )
            for world in worlds
        ]
        deadline = self._connection.deadline(timeout)
        # Only now, when nothing is wrong with any of them, the collected commands leave their worlds.
        prepared = [world._take_along(request) for world, request in zip(worlds, requests)]
        together = wire.StepWorldsRequest(requests=[each.request for each in prepared])
        call = self._connection.stream("StepWorlds", together, deadline)
        end: GenphysError = GenphysError("the server left this world out")
        found: dict[int, StepResult | GenphysError] = {}
        try:
            for message in call:
                for each in message.results:
                    if each.HasField("refusal"):
                        found[each.index] = prepared[each.index].refused(from_refusal(each.refusal))
                    else:
                        found[each.index] = prepared[each.index].result(each.response)
        except grpc.RpcError as error:
            finish(call)
            end = from_rpc_error(error, ended_here=self._connection.closed, request=wire.StepWorldsRequest)
        return [found.get(index, end) for index in range(len(prepared))]

    def list_worlds(self, *, timeout: float | None = None) -> list[WorldInfo]:
        """Returns all worlds of this server, in order of name."""
        found: list[WorldInfo] = []
        request = wire.ListWorldsRequest(page_size=_PAGE_SIZE)
        while True:
            response = self._connection.call("ListWorlds", request, timeout)
            found += [_decode.world_info(*each) for each in zip(response.worlds, response.stamps)]
            if not response.next_page_token:
                return found
            request.page_token = response.next_page_token


def connect(address: str = "127.0.0.1:50051", *, timeout: float = DEFAULT_TIMEOUT_SECONDS) -> Server:
    """Joins a server that runs already.

    Args:
        address: As in "127.0.0.1:50051" or "unix:/path/to.sock".
        timeout: Default deadline of every call, seconds.

    Raises:
        UnavailableError: no server answers there.
    """
    connection = Connection(address, timeout)
    server = Server(connection)
    try:
        server.engines()
    except UnavailableError as error:
        connection.close()
        is_address = address.startswith("unix:") or re.fullmatch(r"[^/]+:\d+", address)
        cure = f"start one with `genphysd --listen {address}`" if is_address else "write host:port, as in 127.0.0.1:50051"
        raise UnavailableError(
            f"no genphys server answers at {address}: {cure}, or use genphys.launch() to get a private one "
            f"({error.message})",
            code=error.code,
        ) from None
    except BaseException:
        connection.close()
        raise
    return server


def launch(
    *,
    engine: str | None = None,
    binary: str | None = None,
    arguments: Iterable[str] = (),
    start_timeout: float = 20.0,
    timeout: float = DEFAULT_TIMEOUT_SECONDS,
) -> Server:
    """Starts a private server and connects to it; it ends with `close()`, with the `with`, or with this program.

    Args:
        engine: Engine of worlds that name none, as in "ode"; None is the server's default.
        binary: Path of genphysd; None looks at $GENPHYS_SERVER, at PATH, and at build/release/bin of a checkout.
        arguments: Further options of genphysd.
        start_timeout: How long it may take to serve, seconds.
        timeout: Default deadline of every call, seconds.

    Raises:
        LaunchError: there is no genphysd, or it did not start; the message says what to do.
    """
    if engine is not None:
        text(engine, "engine", '"ode"')
    options = [*([] if engine is None else ["--default-engine", engine]), *map(str, items(arguments, "arguments"))]
    process = ServerProcess(find_server(binary), options, start_timeout)
    try:
        return Server(process.connect(timeout), process)
    except BaseException:
        process.end()
        raise
