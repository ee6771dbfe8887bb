"""The verbs that make, change and remove entities."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from . import _encode, model
from ._contract import make, wire
from ._verbs import Verbs
from .model import Entity, Vector
from .options import EntityOptions, ShapeOptions, explained

if TYPE_CHECKING:
    from typing_extensions import Unpack

_OF_ANY_GROUND = {
    "motion",
    "geometries",
    "error_correction",
    "ignored_entities",
    "linear_velocity",
    "angular_velocity",
}
_OF_WHAT_MOVES = [name for name in (*_encode.BODY_KEYWORDS, "density") if name not in _OF_ANY_GROUND]
_SHAPE_KEYWORDS = (_encode.ENTITY_KEYWORDS - {"geometries", "physics"}) | set(_encode.GEOMETRY_KEYWORDS)


class EntityVerbs(Verbs):
    """Those of `Commands`."""

    @explained(ShapeOptions)
    def add_sphere(self, *, radius: float = 0.5, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a ball of this radius in metres.

        Without mass or density the world's default density counts.
        """
        return self._add("add_sphere", model.Sphere(radius), options)

    @explained(ShapeOptions)
    def add_box(self, *, half_extents: Vector = (0.5, 0.5, 0.5), **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a block with these half edges in metres."""
        return self._add("add_box", model.Box(half_extents), options)

    @explained(ShapeOptions)
    def add_capsule(self, *, radius: float = 0.5, half_length: float = 0.5, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a cylinder along its z with round ends; `half_length` in metres is of the straight part."""
        return self._add("add_capsule", model.Capsule(radius, half_length), options)

    @explained(ShapeOptions)
    def add_cylinder(self, *, radius: float = 0.5, half_length: float = 0.5, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a cylinder along its z with flat ends; metres."""
        return self._add("add_cylinder", model.Cylinder(radius, half_length), options)

    @explained(ShapeOptions)
    def add_cone(self, *, radius: float = 0.5, half_length: float = 0.5, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a cone with its apex at its z = half_length and its base across -half_length; metres."""
        return self._add("add_cone", model.Cone(radius, half_length), options)

    @explained(ShapeOptions)
    def add_ellipsoid(self, *, semi_axes: Vector = (0.5, 0.5, 0.5), **options: Unpack[ShapeOptions]) -> Entity:
        """Adds an ellipsoid with these half axes in metres."""
        return self._add("add_ellipsoid", model.Ellipsoid(semi_axes), options)

    @explained(ShapeOptions)
    def add_convex_hull(self, vertices: Any, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds the smallest convex body around (n, 3) points in metres."""
        return self._add("add_convex_hull", model.ConvexHull(vertices), options)

    @explained(ShapeOptions)
    def add_mesh(self, vertices: Any, indices: Any, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a static (or, with motion="kinematic", kinematic) surface of triangles; see `TriangleMesh`."""
        return self._add_ground("add_mesh", model.TriangleMesh(vertices, indices), options)

    @explained(ShapeOptions)
    def add_heightfield(self, heights: Any, *, cell_size: float = 1.0, **options: Unpack[ShapeOptions]) -> Entity:
        """Adds a static (or, with motion="kinematic", kinematic) ground of heights; see `Heightfield`."""
        return self._add_ground("add_heightfield", model.Heightfield(heights, cell_size), options)

    @explained(ShapeOptions)
    def add_plane(
        self, *, normal: Vector = (0.0, 0.0, 1.0), offset: float = 0.0, **options: Unpack[ShapeOptions]
    ) -> Entity:
        """Adds a static half space, solid where dot(normal, p) <= offset; offset in metres."""
        return self._add_ground("add_plane", model.Plane(normal, offset), options)

    @explained(EntityOptions)
    def add_entity(
        self, *, geometries: Sequence[model.Geometry] = (), physics: bool = True, **options: Unpack[EntityOptions]
    ) -> Entity:
        """Adds an entity with any number of geometries, or without physics.

        Args:
            geometries: What it collides with; without any it needs a mass.
            physics: False for something that stays where it is put and collides with nothing.
            options: See below.
        """
        _encode.known(options, _encode.ENTITY_KEYWORDS, "add_entity")
        if not physics:
            told = {**options, "geometries": geometries or None}
            _refuse(told, _encode.BODY_KEYWORDS, "physics=False makes what has no body")
        return self._create(_encode.entity(self._home, geometries=geometries, physics=physics, **options))

    @explained(EntityOptions)
    def update_entity(
        self,
        entity: Entity | int,
        *,
        clear: Sequence[str] = (),
        **options: Any,
    ) -> None:
        """Changes a live entity: what is given is replaced, the rest stays.

        Args:
            entity: Which.
            clear: Keywords whose values it loses or takes back to their defaults: "mass", "visual", "physics" ...
            options: Keywords of `add_entity`. geometries are all that it has from then on: keep the id of one that
                stays; of one that is changed too. A mass, centre or tensor replaces all three. A position or an
                orientation alone leaves the other one, as `set_pose` does; None leaves it, too. Physics comes to an
                entity without by physics=True, with all that belongs to it.
        """
        pose = {name: options.pop(name, None) for name in ("position", "orientation")}
        halves = [name for name, value in pose.items() if value is not None]
        if len(halves) == 2:
            options |= pose
        whole = options.pop("physics", None)
        if whole is False:
            _refuse(options, _encode.BODY_KEYWORDS, "physics=False takes the body away")
        cleared = [*_encode.cleared(clear), *(["rigid_body"] if whole is False else [])]
        message, paths = _encode.entity_update(self._home, options, whole=bool(whole))
        message.id = _encode.entity_id(entity, self._home)
        commands = []
        if paths or cleared or not halves:
            update = wire.UpdateEntity(entity=message)
            update.update_mask.paths.extend([*paths, *cleared])
            commands.append(wire.Command(update_entity=update))
        if len(halves) == 1:
            # An update replaces the whole pose. After it, so that a half is not lost to what it clears.
            half = make.SetPose(entity_id=message.id, pose=_encode.pose(**pose))
            commands.append(wire.Command(set_pose=half))
        self._submit(*commands)

    def remove(self, entity: Entity | int) -> None:
        """Removes an entity and the joints that hold it."""
        self._submit(wire.Command(delete_entity=wire.DeleteEntity(entity_id=_encode.entity_id(entity, self._home))))

    def _add_ground(self, verb: str, shape: model.Shape, options: Any) -> Entity:
        options.setdefault("motion", "static")
        # Whether an engine moves such a shape is for the server to say, but nobody moves what shall not be dynamic.
        if str(options["motion"]).lower() != "dynamic":
            _refuse(options, _OF_WHAT_MOVES, f"{verb} makes what nothing pushes")
        return self._add(verb, shape, options)

    def _add(self, verb: str, shape: model.Shape, options: Any) -> Entity:
        _encode.known(options, _SHAPE_KEYWORDS, verb)
        if options.get("mass") is not None and options.get("density") is not None:
            raise ValueError("give mass or density, not both")
        of_geometry = {key: options.pop(key) for key in _encode.GEOMETRY_KEYWORDS if key in options}
        geometry = model.Geometry(shape=shape, **of_geometry)
        return self._create(_encode.entity(self._home, geometries=[geometry], **options), verb)


def _refuse(options: Any, keywords: Iterable[str], why: str) -> None:
    """Raises ValueError for what would be left out in silence."""
    for name in keywords:
        if options.get(name) is not None:
            raise ValueError(f"{name} has no effect here: {why}")
