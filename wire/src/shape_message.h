#pragma once
#include "genphys/event.h"
#include "genphys/shape.h"
#include "genphys/status.h"
#include "genphys/v1/event.pb.h"
#include "genphys/v1/shape.pb.h"

// Parts of entities and events that queries have too.

namespace genphys {

/// A shape made ready to collide. Refuses what bounds no body; the path starts inside the shape.
Result<Shape> DecodeShape(const v1::Shape& shape);
void EncodeShape(const Shape& shape, v1::Shape* out);

EventContactPoint DecodePoint(const v1::ContactPoint& point);
void EncodePoint(const EventContactPoint& point, v1::ContactPoint* out);

}  // namespace genphys
