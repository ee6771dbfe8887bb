"""Questions about where things are. They change nothing, and every engine answers them alike."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _arguments, _encode, events, model
from ._connection import Connection
from ._contract import make
from .model import Entity


@dataclasses.dataclass(frozen=True, kw_only=True)
class RayEntries:
    """All geometries along rays; one row per hit, ray by ray, for each ray in the order in which it meets them.

    Attributes:
        rays: Number of the ray of each row.
        entity_ids: Whom it hit.
        geometry_ids: Which geometry of that entity.
        fractions: 0 to 1 along the translation.
        normals: Unit length, out of the surface.
        points: Where, in world coordinates, metres.
    """

    rays: NDArray[np.int64]
    entity_ids: NDArray[np.uint64]
    geometry_ids: NDArray[np.uint32]
    fractions: NDArray[np.float64]
    normals: NDArray[np.float64]
    points: NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True)
class ShapeHits:
    """The first geometry that a shape met on each way; row i belongs to way i.

    Attributes:
        hit: Whether there is one.
        entity_ids: Whom it hit; zero without a hit.
        geometry_ids: Which geometry of that entity.
        fractions: 0 to 1 along the translation; 0 for what it overlaps at the start, 1 without a hit.
        points: Where on the surface that was hit, in world coordinates, metres.
        normals: Unit length, out of that surface; zero without a hit.
    """

    hit: NDArray[np.bool_]
    entity_ids: NDArray[np.uint64]
    geometry_ids: NDArray[np.uint32]
    fractions: NDArray[np.float64]
    points: NDArray[np.float64]
    normals: NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Overlaps:
    """All geometries that a shape overlaps; one row per hit, place by place, for each place in order of id.

    Attributes:
        places: Number of the place of each row.
        entity_ids: Whom it overlaps.
        geometry_ids: Which geometry of that entity.
    """

    places: NDArray[np.int64]
    entity_ids: NDArray[np.uint64]
    geometry_ids: NDArray[np.uint32]


@dataclasses.dataclass(frozen=True, kw_only=True)
class ClosestPoints:
    """Closest points of two bodies; row i belongs to question i.

    Attributes:
        hit: Whether there is an answer.
        entity_ids: The second body; zero without an answer.
        geometry_ids: Which geometry of that entity.
        distances: Metres; negative is how deep they overlap.
        first_points: Of the shape that was asked for or the first entity, in world coordinates, metres.
        second_points: Of what is near or the second entity, in world coordinates, metres.
        normals: Unit length, from the second body to the first.
    """

    hit: NDArray[np.bool_]
    entity_ids: NDArray[np.uint64]
    geometry_ids: NDArray[np.uint32]
    distances: NDArray[np.float64]
    first_points: NDArray[np.float64]
    second_points: NDArray[np.float64]
    normals: NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class EntityContact:
    """What touches an entity, and where.

    Attributes:
        other: Whom it touches.
        sensor: Whether one of the two is a sensor.
        points: As the last substep had them, whose impulses they have: an n-th of the step's where it has n and
            nothing changes; of sleepers those of their last solve. In them entity_a is the one with the smaller id.
    """

    other: Entity
    sensor: bool
    points: tuple[events.ContactPoint, ...]


class Queries:
    """The questions. Arguments that are one vector stand for a batch of one."""

    _connection: Connection
    _name: str

    def _entity(self, number: int) -> Entity:
        raise NotImplementedError

    def cast_rays(
        self, origins: Any, translations: Any, *, collides_with_bits: int | None = None, timeout: float | None = None
    ) -> model.RayHits:
        """Returns the first thing that each ray hits, now.

        Args:
            origins: (n, 3) or (3,): where each ray begins, metres.
            translations: (n, 3) or (3,): from its beginning to its end, metres.
            collides_with_bits: The categories that stop a ray, one bit each; None is all.
            timeout: Seconds.
        """
        starts, ways = _each_with_each(origins=origins, translations=translations)
        request = make.CastRaysRequest(
            world=self._name,
            origins=_arguments.row_column(starts, 3, "origins"),
            translations=_arguments.row_column(ways, 3, "translations"),
            collides_with_bits=collides_with_bits,
        )
        response = self._connection.call("CastRays", request, timeout)
        ids = np.frombuffer(response.entity_ids, "<u8")
        fractions = np.frombuffer(response.fractions, "<f8")
        return model.RayHits(
            hit=ids != 0,
            entity_ids=ids,
            fractions=fractions,
            normals=np.frombuffer(response.normals, "<f8").reshape(-1, 3),
            points=starts + fractions[:, np.newaxis] * ways,
        )

    def cast_rays_through(
        self, origins: Any, translations: Any, *, collides_with_bits: int | None = None, timeout: float | None = None
    ) -> RayEntries:
        """Returns everything that each ray hits, now; the arguments are those of `cast_rays`."""
        starts, ways = _each_with_each(origins=origins, translations=translations)
        request = make.CastRaysRequest(
            world=self._name,
            origins=_arguments.row_column(starts, 3, "origins"),
            translations=_arguments.row_column(ways, 3, "translations"),
            collides_with_bits=collides_with_bits,
            all_hits=True,
        )
        response = self._connection.call("CastRays", request, timeout)
        rays = _numbered(response.hit_counts)
        fractions = np.frombuffer(response.fractions, "<f8")
        return RayEntries(
            rays=rays,
            entity_ids=np.frombuffer(response.entity_ids, "<u8"),
            geometry_ids=np.array(response.geometry_ids, np.uint32),
            fractions=fractions,
            normals=_vectors(response.normals),
            points=starts[rays] + fractions[:, np.newaxis] * ways[rays],
        )

    def cast_shape(
        self,
        shape: model.Shape,
        positions: Any,
        translations: Any,
        *,
        orientations: Any = None,
        collides_with_bits: int | None = None,
        timeout: float | None = None,
    ) -> ShapeHits:
        """Returns what a shape meets first on its way along straight lines, without turning.

        Args:
            shape: A bounded convex one.
            positions: (n, 3) or (3,): where each way begins, metres.
            translations: (n, 3) or (3,): from its beginning to its end, metres.
            orientations: (n, 4) or (4,): of the shape, w x y z; None is that of the world.
            collides_with_bits: The categories that stop it, one bit each; None is all.
            timeout: Seconds.
        """
        starts, ways = _each_with_each(positions=positions, translations=translations)
        request = make.CastShapeRequest(
            translations=_arguments.row_column(ways, 3, "translations"),
            **self._posed(shape, starts, orientations, collides_with_bits),
        )
        response = self._connection.call("CastShape", request, timeout)
        ids = np.frombuffer(response.entity_ids, "<u8")
        return ShapeHits(
            hit=ids != 0,
            entity_ids=ids,
            geometry_ids=np.array(response.geometry_ids, np.uint32),
            fractions=np.frombuffer(response.fractions, "<f8"),
            points=_vectors(response.positions),
            normals=_vectors(response.normals),
        )

    def find_overlaps(
        self,
        shape: model.Shape,
        positions: Any,
        *,
        orientations: Any = None,
        collides_with_bits: int | None = None,
        timeout: float | None = None,
    ) -> Overlaps:
        """Returns all that a shape overlaps at places; the arguments are those of `cast_shape`."""
        places = _many(positions)
        request = make.FindOverlapsRequest(**self._posed(shape, places, orientations, collides_with_bits))
        response = self._connection.call("FindOverlaps", request, timeout)
        return Overlaps(
            places=_numbered(response.hit_counts),
            entity_ids=np.frombuffer(response.entity_ids, "<u8"),
            geometry_ids=np.array(response.geometry_ids, np.uint32),
        )

    def find_closest(
        self,
        shape: model.Shape,
        positions: Any,
        *,
        orientations: Any = None,
        distance_max: float | None = None,
        collides_with_bits: int | None = None,
        timeout: float | None = None,
    ) -> ClosestPoints:
        """Returns what is nearest to a shape at places, and how far away it is.

        Args:
            shape: A bounded convex one; a small ball asks for a point.
            positions: (n, 3) or (3,): the places, metres.
            orientations: (n, 4) or (4,): of the shape, w x y z; None is that of the world.
            distance_max: What is farther away does not count, metres; None is 100.
            collides_with_bits: The categories that count, one bit each; None is all.
            timeout: Seconds.
        """
        places = _many(positions)
        request = make.FindClosestRequest(
            distance_max=distance_max, **self._posed(shape, places, orientations, collides_with_bits)
        )
        return _closest(self._connection.call("FindClosest", request, timeout).closest)

    def distances(
        self, first: Iterable[Entity | int], second: Iterable[Entity | int], *, timeout: float | None = None
    ) -> ClosestPoints:
        """Returns how far each entity of `first` is from that of `second`."""
        request = make.MeasureDistancesRequest(
            world=self._name,
            from_ids=_encode.entity_column(first, "first", self._name),
            to_ids=_encode.entity_column(second, "second", self._name),
        )
        return _closest(self._connection.call("MeasureDistances", request, timeout).closest)

    def contacts_of(self, entity: Entity | int, *, timeout: float | None = None) -> list[EntityContact]:
        """Returns what touches an entity as of the last step, in order of id."""
        request = make.GetContactsRequest(world=self._name, entity_id=_encode.entity_id(entity, self._name))
        return [
            EntityContact(
                self._entity(each.other_id), each.is_sensor, tuple(events.contact_point(point) for point in each.points)
            )
            for each in self._connection.call("GetContacts", request, timeout).contacts
        ]

    def _posed(self, shape: model.Shape, places: Any, orientations: Any, bits: int | None) -> dict[str, Any]:
        turns = b""
        if orientations is not None:
            each = _arguments.rows(_many(orientations, 4), 4, "orientations")
            if len(each) not in (1, len(places)):
                raise ValueError(f"orientations has {len(each)} rows, not 1 or {len(places)}, as many as positions")
            turns = np.broadcast_to(each, (len(places), 4)).tobytes()
        return {
            "world": self._name,
            "shape": _encode.shape(shape),
            "positions": _arguments.row_column(places, 3, "positions"),
            "orientations": turns,
            "collides_with_bits": bits,
        }


def _vectors(column: bytes) -> NDArray[np.float64]:
    return np.frombuffer(column, "<f8").reshape(-1, 3)


def _many(values: Any, width: int = 3) -> NDArray[Any]:
    """Returns rows: one vector stands for one row, and an empty list for none."""
    array = np.atleast_2d(values)
    return array.reshape(0, width) if array.shape == (1, 0) else array


def _each_with_each(**rows: Any) -> list[NDArray[Any]]:
    """Returns arrays of as many rows each, of which one row may stand for all."""
    arrays = [_many(values) for values in rows.values()]
    try:
        return list(np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = ", ".join(f"{name} has shape {array.shape}" for name, array in zip(rows, arrays))
        raise ValueError(f"{shapes}: both must be (n, 3), or one of them (3,)") from None


def _numbered(counts: Any) -> NDArray[np.int64]:
    return np.repeat(np.arange(len(counts)), np.array(counts, np.int64))


def _closest(columns: Any) -> ClosestPoints:
    ids = np.frombuffer(columns.entity_ids, "<u8")
    return ClosestPoints(
        hit=ids != 0,
        entity_ids=ids,
        geometry_ids=np.array(columns.geometry_ids, np.uint32),
        distances=np.frombuffer(columns.distances, "<f8"),
        first_points=_vectors(columns.first_points),
        second_points=_vectors(columns.second_points),
        normals=_vectors(columns.normals),
    )
