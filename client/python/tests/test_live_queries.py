"""Shapes and questions about them, on the real server."""

import numpy as np
import pytest

import genphys

# The accuracy of the server's narrow phase at this size, metres.
EXACT = 1e-9

CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


def test_every_shape_comes_back_as_it_was_sent(world):
    square = genphys.TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    field = genphys.Heightfield([[0, 0.1, 0.2], [0.3, 0.4, 0.5]], cell_size=0.5)
    for shape, entity in [
        (genphys.Cone(0.4, 0.6), world.add_cone(radius=0.4, half_length=0.6, mass=1.0)),
        (genphys.Ellipsoid((0.4, 0.5, 0.6)), world.add_ellipsoid(semi_axes=(0.4, 0.5, 0.6), mass=1.0)),
        (genphys.ConvexHull(CORNERS), world.add_convex_hull(CORNERS, mass=1.0)),
        (square, world.add_mesh(square.vertices, square.indices)),
        (field, world.add_heightfield(field.heights, cell_size=0.5)),
    ]:
        assert world.entity(entity).geometries[0].shape == shape


def test_a_hull_cube_comes_to_rest_on_a_mesh_where_a_box_does(world):
    square = [[-9, -9, 1], [9, -9, 1], [9, 9, 1], [-9, 9, 1]]
    world.add_mesh(square, [[0, 1, 2], [0, 2, 3]])
    hull = world.add_convex_hull(CORNERS, mass=1.0, position=(0, 0, 1.5))
    box = world.add_box(mass=1.0, position=(3, 0, 1.5))

    frame = world.step(120)

    heights = frame.positions[[frame.row(hull), frame.row(box)], 2]
    assert heights == pytest.approx(1.5, abs=1e-3)
    assert heights[0] == pytest.approx(heights[1], abs=1e-4)


def test_a_dynamic_mesh_is_refused_by_name(world):
    with pytest.raises(genphys.UnsupportedFeatureError, match="dynamic_triangle_mesh"):
        world.add_mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], motion="dynamic", mass=1.0)


def test_flat_points_are_no_hull(world):
    with pytest.raises(genphys.InvalidValueError, match="INVALID_VALUE at vertices"):
        world.add_convex_hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], mass=1.0)


def test_a_ray_tells_of_all_that_it_passes(world):
    low = world.add_box(motion="static", position=(0, 0, 2))
    high = world.add_sphere(motion="static", position=(0, 0, 5))

    with pytest.raises(ValueError, match=r"origins has shape \(1, 3\), translations has shape \(1, 2\)"):
        world.cast_rays_through([0, 0, 10], [0, 0])
    found = world.cast_rays_through([[0, 0, 10], [9, 0, 9]], [0, 0, -9])

    assert found.rays.tolist() == [0, 0, 1]
    assert found.entity_ids[:2].tolist() == [high.id, low.id]
    assert found.points[:, 2] == pytest.approx([5.5, 2.5, 0], abs=EXACT)
    assert found.normals == pytest.approx(np.tile([0, 0, 1], (3, 1)), abs=EXACT)


def test_a_shape_is_stopped_by_what_it_meets_first(world):
    box = world.add_box(motion="static", position=(0, 0, 2))

    found = world.cast_shape(genphys.Sphere(0.25), [[0, 0, 9], [5, 0, 9], [5, 0, 9]], [[0, 0, -8], [0, 0, -10], [0, 0, -8]])

    assert found.hit.tolist() == [True, True, False]
    assert found.entity_ids[0] == box.id
    assert found.fractions == pytest.approx([(9 - 2.75) / 8, (9 - 0.25) / 10, 1], abs=EXACT)
    assert found.points[0] == pytest.approx([0, 0, 2.5], abs=1e-6)


def test_overlaps_and_distances_are_told(world):
    box = world.add_box(motion="static", position=(0, 0, 2))
    ball = world.add_sphere(motion="static", position=(3, 0, 2))
    probe = genphys.Box((0.5, 0.5, 0.5))

    overlaps = world.find_overlaps(probe, [[0.9, 0, 2], [1.1, 0, 2]])
    closest = world.find_closest(probe, [1.1, 0, 2])
    distances = world.distances([box, ball], [ball, box])

    assert (overlaps.places.tolist(), overlaps.entity_ids.tolist()) == ([0], [box.id])
    assert (closest.hit.tolist(), closest.entity_ids.tolist()) == ([True], [box.id])
    assert closest.distances == pytest.approx([0.1], abs=EXACT)
    assert closest.normals[0] == pytest.approx([1, 0, 0], abs=EXACT)
    assert distances.distances == pytest.approx([2, 2], abs=EXACT)
    assert distances.second_points[:, 0] == pytest.approx([2.5, 0.5], abs=1e-6)


def test_contacts_of_an_entity_name_the_other_one(world):
    crate = world.add_box(mass=2.0, position=(0, 0, 0.5))
    world.step(10)

    (contact,) = world.contacts_of(crate)

    assert not contact.sensor
    assert len(contact.points) == 4
    assert all(point.normal == pytest.approx((0, 0, 1)) for point in contact.points)
    assert contact.points[0].normal_impulse > 0


def test_a_question_about_a_plane_is_refused(world):
    with pytest.raises(genphys.InvalidValueError, match="shape"):
        world.find_overlaps(genphys.Plane(), [0, 0, 0])
    with pytest.raises(ValueError, match="positions"):
        world.find_overlaps(genphys.Sphere(), [0, 0])
