"""Commands that are collected, to be sent together."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from . import fields
from ._contract import wire
from .commands import Commands
from .joints import Joint
from .model import Entity


class Batch(Commands):
    """Commands that go with the next `World.step`; made by `World.batch`, and full at the end of its block."""

    def __init__(self, home: str) -> None:
        self._home = home
        self.commands: list[Any] = []
        self.verbs: dict[int, str] = {}
        """What a command that makes an entity of one shape was called, by its place, as in "add_box"."""
        self._ended = False
        self._created: dict[int, Entity] = {}
        self._joined: dict[int, Joint] = {}
        self._created_fields: dict[int, fields.ForceField] = {}

    def __len__(self) -> int:
        return len(self.commands)

    def _create(self, entity: Any, verb: str = "") -> Entity:
        handle = Entity(None, entity.display_name, self._home)
        self._submit(wire.Command(create_entity=wire.CreateEntity(entity=entity)))
        if verb:
            self.verbs[len(self.commands) - 1] = verb
        self._created[len(self.commands) - 1] = handle
        return handle

    def _create_field(self, command: Any) -> fields.ForceField:
        handle = fields.ForceField(home=self._home)
        self._submit(wire.Command(create_force_field=command))
        self._created_fields[len(self.commands) - 1] = handle
        return handle

    def _made_by(self, entity: Any) -> int | None:
        for index, handle in self._created.items():
            if handle is entity and handle._id is None:
                return index
        return None

    def _submit(self, *commands: Any) -> None:
        if self._ended:
            # What came later would go nowhere: the world took the commands along when the block ended.
            raise ValueError("the block of this batch has ended: open another one with world.batch()")
        self.commands += commands

    def _end(self) -> None:
        self._ended = True

    def _join(self, joint: Any) -> Joint:
        handle = Joint(None, self._home)
        self._submit(wire.Command(create_joint=wire.CreateJoint(joint=joint)))
        self._joined[len(self.commands) - 1] = handle
        return handle

    def _side(self, entity: Entity | int | None) -> Any:
        index = self._made_by(entity)
        return super()._side(entity) if index is None else wire.EntityRef(created_by_command=index)

    def _append(self, other: Batch) -> None:
        offset = len(self.commands)
        for command in other.commands:
            # Sides that the batch itself creates are named by their place, which is another one now.
            for side in (command.create_joint.joint.entity_a, command.create_joint.joint.entity_b):
                if command.HasField("create_joint") and side.WhichOneof("kind") == "created_by_command":
                    side.created_by_command += offset
            if command.HasField("create_force_field"):
                fields.shift(command.create_force_field, offset)
        self.commands += other.commands
        self.verbs.update({offset + index: verb for index, verb in other.verbs.items()})
        self._joined.update({offset + index: handle for index, handle in other._joined.items()})
        self._created.update({offset + index: handle for index, handle in other._created.items()})
        self._created_fields.update({offset + index: handle for index, handle in other._created_fields.items()})

    def _settle(self, id_of: Callable[[int], int | None]) -> tuple[Entity, ...]:
        """Gives what was created the id that its command got, if that is known, and returns the entities in order."""
        if not (self._created or self._joined or self._created_fields):
            return ()
        for handles in (self._created, self._joined, self._created_fields):
            for index, handle in handles.items():
                handle._id = id_of(index)
                handle._failed = handle._id is None
        return tuple(self._created[index] for index in sorted(self._created) if self._created[index]._id is not None)
