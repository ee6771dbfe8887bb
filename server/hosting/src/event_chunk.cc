#include <variant>

#include "genphys/hosting/event_log.h"
#include "genphys/surface.h"
#include "genphys/wire/encode.h"
#include "genphys/wire/wire_format.h"

namespace genphys {
namespace {

size_t RoughSize(const EntityDesc& entity) {
  size_t bytes = sizeof(EntityDesc) + entity.display_name.size();
  if (entity.rigid_body) {
    for (const Geometry& geometry : entity.rigid_body->geometries) {
      bytes += sizeof(Geometry) + DataBytesOf(geometry.shape);
    }
  }
  if (entity.visual) bytes += entity.visual->uri.size() + entity.visual->media_type.size() + entity.visual->data.size();
  return bytes;
}

size_t RoughSize(const Event& event) {
  return sizeof(Event) + std::visit(
                             [](const auto& kind) -> size_t {
                               if constexpr (requires { kind.points; }) {
                                 return kind.points.size() * sizeof(EventContactPoint);
                               } else if constexpr (requires { kind.entity; }) {
                                 return RoughSize(*kind.entity);
                               } else {
                                 return 0;
                               }
                             },
                             event.kind);
}

}  // namespace

EventChunk::EventChunk(const Stamp& stamp, std::vector<Event> events) : stamp_(stamp), events_(std::move(events)) {
  for (const Event& event : events_) bytes_ += RoughSize(event);
}

std::string_view EventChunk::Encoded(size_t begin, size_t end, bool contact_points) const {
  Encoding& encoding = encodings_[contact_points ? 1 : 0];
  std::call_once(encoding.once, [&] {
    std::string bytes;
    std::vector<size_t> offsets{0};
    for (const Event& event : events_) {
      v1::Event message;
      EncodeEvent(event, &message, contact_points);
      AppendField(v1::EventBatch::kEventsFieldNumber, message.SerializeAsString(), bytes);
      offsets.push_back(bytes.size());
    }
    encoding.bytes = std::move(bytes);
    encoding.offsets = std::move(offsets);
  });
  const size_t first = encoding.offsets[begin];
  return std::string_view(encoding.bytes).substr(first, encoding.offsets[end] - first);
}

void TouchingNow::Follow(const Event& event) {
  if (const auto* began = std::get_if<ContactBegan>(&event.kind)) contacts_.insert(began->pair);
  if (const auto* ended = std::get_if<ContactEnded>(&event.kind)) contacts_.erase(ended->pair);
  if (const auto* entered = std::get_if<SensorEntered>(&event.kind)) visits_.emplace(entered->sensor, entered->visitor);
  if (const auto* left = std::get_if<SensorLeft>(&event.kind)) visits_.erase({left->sensor, left->visitor});
}

std::vector<Event> TouchingNow::Pairs(uint64_t step) const {
  std::vector<Event> events;
  for (const EntityPair& pair : contacts_) events.push_back({0, step, ContactPersisted{pair, {}}});
  for (const auto& [sensor, visitor] : visits_) events.push_back({0, step, SensorEntered{sensor, visitor}});
  return events;
}

}  // namespace genphys
