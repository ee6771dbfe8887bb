"""What a user of this package calls what the contract names otherwise.

A server names fields by their path in the contract, as in "entity.rigid_body.inertia.mass", which nobody wrote who
called `add_box(mass=...)`. `parts_of` follows such a path through the messages and says of each field what the user
calls it: most as the contract does, the others as `_NAMES` says. `tests/test_naming.py` walks all of the contract.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from google.protobuf.descriptor import FieldDescriptor

_NAMES = {
    # Known by the field alone, wherever it is.
    "display_name": "name",
    "entity_id": "entity",
    "entity_ids": "entities",
    "every_nth_step": "every",
    "ignored_entity_ids": "ignored_entities",
    "is_sensor": "sensor",
    "joint_id": "joint",
    "limits": "",
    "lower_metres": "lower",
    "lower_radians": "lower",
    "material": "",
    "motion_type": "motion",
    "rest_metres": "rest",
    "rest_radians": "rest",
    "rest_time_seconds": "rest_time",
    "scalar": "dtype",
    "slop_metres": "slop",
    "step_size_seconds": "step_size",
    "swing_max_radians": "swing_max",
    "target_metres": "position",
    "target_radians": "position",
    "target_velocity": "velocity",
    "time_constant_seconds": "time_constant",
    "torque_max": "force_max",
    "upper_metres": "upper",
    "upper_radians": "upper",
    # Messages that are several arguments of one call.
    "ApplyForceRequest.force": "",
    "CreateEntity.entity": "",
    "CreateEntityRequest.entity": "",
    "CreateForceField.field": "",
    "CreateJoint.joint": "",
    "CreateWorldRequest.world": "",
    "DriveRequest.step": "",
    "Entity.pose": "",
    "Entity.rigid_body": "",
    "Geometry.pose_in_entity": "",
    "RigidBody.inertia": "",
    "SetPose.pose": "",
    "SetStepper.stepper": "",
    "UpdateEntity.entity": "",
    "UpdateForceField.field": "",
    "UpdateJoint.joint": "",
    "World.defaults": "",
    "World.stepper": "",
    # Which of them it is, the user says by the class of a value.
    "Command.kind": "",
    "EntityRef.kind": "",
    "ForceField.kind": "field",
    "Joint.kind": "kind",
    "Shape.kind": "",
    # Verbs.
    "Command.create_entity": "add_entity",
    "Command.create_force_field": "add_field",
    "Command.create_joint": "join",
    "Command.delete_entity": "remove",
    "Command.delete_force_field": "remove_field",
    "Command.delete_joint": "remove_joint",
    "Command.update_force_field": "update_field",
    "Command.update_joint": "change_joint",
    # Others.
    "BallJoint.twist": "twist_",
    "CreateForceField.created_by_commands": "entities",
    "CreateForceField.spring_a_created_by_command": "field.a",
    "CreateForceField.spring_b_created_by_command": "field.b",
    "DeleteForceField.field_id": "number",
    "DeleteWorldRequest.name": "world",
    "Entity.id": "entity",
    "ForceField.id": "number",
    "Heightfield.columns": "heights.shape[1]",
    "Heightfield.rows": "heights.shape[0]",
    "GetWorldRequest.name": "world",
    "Inertia.tensor": "inertia_tensor",
    "Joint.id": "joint",
    "MeasureDistancesRequest.from_ids": "first",
    "MeasureDistancesRequest.to_ids": "second",
    "PauseWorldRequest.name": "world",
    "PlayWorldRequest.name": "world",
    "Region.corner": "[0]",
    "Region.opposite_corner": "[1]",
    "ResetWorldRequest.name": "world",
    "SetMotorColumns.joint_ids": "of",
    "SetMotorColumns.targets": "velocities",
    "SpringField.entity_a": "a",
    "SpringField.entity_b": "b",
    "StepWorldsRequest.requests": "worlds",
    "UpdateEntity.update_mask": "clear",
    "UpdateJoint.update_mask": "kind",
    "WatchEventsRequest.after_sequence": "after",
    "WatchEventsRequest.epoch": "after",
}
"""By field, or by message and field or oneof. Empty: the user does not name it, only what is in it. What begins with a
bracket is a part of what comes before, and what ends in "_" the beginning of what comes after."""

_INDICES: dict[str, Callable[[int], str]] = {
    "ConvexHull.vertices": lambda i: f"[{i // 3}][{i % 3}]",
    "FieldMask.paths": lambda i: "",
    "Heightfield.heights": lambda i: f".flat[{i}]",
    "Inertia.tensor": lambda i: "",
    "TriangleMesh.indices": lambda i: f"[{i // 3}][{i % 3}]",
    "TriangleMesh.vertices": lambda i: f"[{i // 3}][{i % 3}]",
}
"""How the user counts in what travels as one list of numbers; a tensor may be given in two ways."""

_QUATERNIONS = ("Quaternion", "orientation", "orientations")
_STEP = re.compile(r"([A-Za-z]\w*)(?:\[(\d+)\])?")
_WORD = re.compile(r"[a-z]\w*(?:\[\d+\])?(?:\.[a-z]\w*(?:\[\d+\])?)*")
_RESOURCE = re.compile(r"(?<![\w/])(?:worlds|engines)/(?=\S)")


def _index(number: int) -> str:
    return f"[{number}]"


def name_of(message: Any, field: str) -> str:
    """Returns what the user calls a field or oneof of the message with this descriptor."""
    whole = f"{message.name}.{field}"
    if whole in _NAMES:
        return _NAMES[whole]
    if field in _NAMES:
        return _NAMES[field]
    of = message.fields_by_name.get(field)
    if message.name == "Command":
        return field  # a verb
    oneof = of.containing_oneof if of is not None else None
    return _NAMES.get(f"{message.name}.{oneof.name}", field) if oneof is not None else field


def parts_of(message: Any, path: str) -> list[str] | None:
    """Returns what the user calls the steps of a path from the message with this descriptor; None if it has no such."""
    parts: list[str] = []
    start, holder, last, is_column = "", message, "", False
    for step in path.split("."):
        match = _STEP.fullmatch(step)
        if match is None:
            return None
        name, index = match[1], match[2]
        if is_column or (holder is not None and holder.name in ("Vector3", "Quaternion")):
            components = "wxyz" if last in _QUATERNIONS else "xyz"
            if name not in components or len(name) != 1 or not parts:
                return None
            parts[-1] += f"[{components.index(name)}]"
            continue
        if holder is None:
            return None
        field = holder.fields_by_name.get(name)
        if field is None and name not in holder.oneofs_by_name:
            return None
        said = name_of(holder, name)
        whole = f"{holder.name}.{name}"
        counted = "" if index is None else _INDICES.get(whole, _index)(int(index))
        if said.endswith("_"):
            start = said
        elif said.startswith("[") and parts:
            parts[-1] += said + counted
        elif said:
            parts.append(start + said + counted)
            start = ""
        last, is_column = name, field is not None and field.type == FieldDescriptor.TYPE_BYTES
        holder = None if field is None else field.message_type
        if holder is not None and holder.name == "FieldMask":
            break
    return parts


def message_of(message: Any, path: str, text: str) -> str:
    """Returns what a server says of a path, with the names that the user knows."""
    holders, holder = [message], message
    for step in path.split("."):
        field = holder.fields_by_name.get(step.partition("[")[0])
        if field is None or field.message_type is None:
            break
        holder = field.message_type
        holders.append(holder)
    blamed = path.rpartition(".")[2]

    def told(match: re.Match[str]) -> str:
        word = match[0]
        if "_" not in word and "." not in word and not (word == blamed and match.start() == 0):
            return word  # of the language, not of the contract
        for holder in reversed(holders):
            parts = parts_of(holder, word)
            if parts:
                return parts[-1] if word == path else ".".join(parts)
        return word

    return _RESOURCE.sub("", _WORD.sub(told, text) if path else text)


def of_call(argument: str) -> str:
    """Returns an argument of a command as whoever gave this command alone knows it."""
    return re.sub(r"^commands\[\d+\]\.\w+\.?", "", argument)


def of_shape(argument: str) -> str:
    """Returns an argument of `add_entity` as whoever called `add_box` or its like knows it."""
    return re.sub(r"\bgeometries\[0\]\.?(?:shape\b\.?)?", "", argument)


def of_batch(argument: str, verbs: Mapping[int, str]) -> str:
    """The same of an argument of a batch; `verbs` says by its place what a command that makes an entity was called."""
    match = re.match(r"commands\[(\d+)\]\.add_entity\b\.?", argument)
    verb = verbs.get(int(match[1])) if match else None
    if match is None or verb is None:
        return argument
    rest = of_shape(argument[match.end() :])
    return f"commands[{match[1]}].{verb}" + (f".{rest}" if rest else "")
