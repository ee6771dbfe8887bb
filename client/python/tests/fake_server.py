"""A gRPC server with the answers of a test, for what a real server cannot be made to do at will."""

from __future__ import annotations

from collections.abc import Callable
from concurrent import futures
from typing import Any

import grpc
from google.protobuf import any_pb2

from genphys._contract import METHODS, message_class, wire

WORKERS = 8
EPOCH = 7
FIRST_ID = 1 << 32


class FakeServer:
    """Serves the given methods; the others are unimplemented, except those that every connection begins with."""

    def __init__(self, address: str = "127.0.0.1:0", **answers: Callable[[Any, Any], Any]) -> None:
        self.answers: dict[str, Callable[[Any, Any], Any]] = {
            "ListEngines": lambda request, context: wire.ListEnginesResponse(),
            "ListEntities": lambda request, context: wire.ListEntitiesResponse(),
            **answers,
        }
        self.requests: list[tuple[str, Any]] = []
        self._server = grpc.server(futures.ThreadPoolExecutor(WORKERS), options=[("grpc.so_reuseport", 0)])
        services: dict[str, dict[str, grpc.RpcMethodHandler]] = {}
        for name, method in METHODS.items():
            if name in self.answers:
                _, service, _ = method.path.split("/")
                services.setdefault(service, {})[name] = self._handler(name, method)
        for service, handlers in services.items():
            self._server.add_generic_rpc_handlers((grpc.method_handlers_generic_handler(service, handlers),))
        port = self._server.add_insecure_port(address)
        self.address = f"127.0.0.1:{port}"
        self._server.start()

    def __enter__(self) -> FakeServer:
        return self

    def __exit__(self, *exception: object) -> None:
        self.stop()

    def stop(self) -> None:
        """Ends at once, breaking what is under way."""
        self._server.stop(None).wait()

    def received(self, name: str) -> list[Any]:
        """The requests of one method so far."""
        return [request for method, request in self.requests if method == name]

    def _handler(self, name: str, method: Any) -> grpc.RpcMethodHandler:
        def answer(request: Any, context: Any) -> Any:
            self.requests.append((name, request))
            return self.answers[name](request, context)

        if method.client_streaming:
            make = grpc.stream_stream_rpc_method_handler
        elif method.server_streaming:
            make = grpc.unary_stream_rpc_method_handler
        else:
            make = grpc.unary_unary_rpc_method_handler
        return make(
            answer,
            request_deserializer=method.request.FromString,
            response_serializer=method.response.SerializeToString,
        )


def answer_step(request: Any, context: Any) -> Any:
    """Answers a Step as the first one of a world; what its commands create is numbered from `FIRST_ID`."""
    response = wire.StepResponse(stamp={"step": 1, "epoch": EPOCH})
    for index, command in enumerate(request.commands):
        is_creation = command.WhichOneof("kind") == "create_entity"
        response.results.add(created_id=FIRST_ID + index if is_creation else 0)
    return response


def last_command(server: FakeServer) -> Any:
    """The one command of the last Step that came."""
    (command,) = server.received("Step")[-1].commands
    return command


def refuse(context: Any, code: grpc.StatusCode, reason: str, message: str, field: str = "") -> None:
    """Ends the call as the real server does: status, one ErrorInfo, and a BadRequest if a field is to blame."""
    details = [_packed("google.rpc.ErrorInfo", reason=reason, domain="genphys", metadata={"engine": "ode"})]
    if field:
        violation = {"field": field, "description": message}
        details.append(_packed("google.rpc.BadRequest", field_violations=[violation]))
    status = message_class("google.rpc.Status")(code=code.value[0], message=message)
    for detail in details:
        status.details.add(type_url=detail.type_url, value=detail.value)
    context.set_trailing_metadata((("grpc-status-details-bin", status.SerializeToString()),))
    context.abort(code, message)


def batch(first: int, *kinds: dict[str, Any], epoch: int = EPOCH) -> Any:
    """A WatchEventsResponse with events numbered from `first`; none is a bookmark before `first`."""
    events = [wire.Event(step=first + index, sequence=first + index, **kind) for index, kind in enumerate(kinds)]
    return wire.WatchEventsResponse(
        stamp={"epoch": epoch},
        batch={"events": events, "first_sequence": first, "last_sequence": first + len(kinds) - 1},
    )


def _packed(kind: str, **fields: Any) -> any_pb2.Any:
    message = message_class(kind)(**fields)
    return any_pb2.Any(type_url=f"type.googleapis.com/{kind}", value=message.SerializeToString())
