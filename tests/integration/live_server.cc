#include "integration/live_server.h"

#include <regex>

namespace genphys::testing {
namespace {

constexpr char kGreeting[] = "genphysd listening on ";

std::vector<std::string> Arguments(const TemporaryFolder& folder) {
  return {"--listen", "unix:" + (folder.path() / "socket").string(), "--exit-with-parent"};
}

uint32_t RowOf(const client::Frame& frame, EntityId id) {
  const std::optional<uint32_t> row = frame.row(id);
  if (!row) throw std::runtime_error("the frame has no entity " + std::to_string(id.packed()));
  return *row;
}

}  // namespace

LiveServer::LiveServer() : process_(Arguments(folder_)) {
  const std::string line = process_.ReadLine();
  if (!line.starts_with(kGreeting)) throw std::runtime_error("the server does not start: " + line);
  address_ = line.substr(sizeof kGreeting - 1);
}

LiveServer::~LiveServer() {
  process_.CloseInput();
  EXPECT_EQ(process_.Wait(), 0) << process_.ReadErrors();
  const std::string errors = process_.ReadErrors();
  static const std::regex report("(ERROR|WARNING): [A-Za-z]+Sanitizer|runtime error:");
  EXPECT_FALSE(std::regex_search(errors, report)) << errors;
}

client::Server LiveServer::Connect() const { return Value(client::Connect(address_)); }

client::WorldOptions WorldOn(const std::string& engine) {
  client::WorldOptions options{.record_state_hash = true};
  options.world.engine = engine;
  options.world.gravity = {0, 0, -9.81};
  return options;
}

Vector3 PositionIn(const client::Frame& frame, EntityId id) { return frame.positions().col(RowOf(frame, id)); }
Vector3 VelocityIn(const client::Frame& frame, EntityId id) { return frame.linear_velocities().col(RowOf(frame, id)); }
Vector3 SpinIn(const client::Frame& frame, EntityId id) { return frame.angular_velocities().col(RowOf(frame, id)); }
bool AsleepIn(const client::Frame& frame, EntityId id) { return frame.asleep(RowOf(frame, id)); }

std::vector<Event> ReadEvents(client::EventStream& stream, uint64_t last_sequence) {
  std::vector<Event> events;
  while (stream.position().sequence < last_sequence) {
    const uint64_t before = stream.position().sequence;
    const auto batch = Value(stream.Next(kPatience));
    if (!batch) throw std::runtime_error("the stream ended");
    EXPECT_FALSE(batch->gap);
    EXPECT_EQ(batch->first_sequence, before + 1);
    for (const Event& event : batch->events) {
      EXPECT_EQ(event.sequence, before + 1 + static_cast<uint64_t>(&event - batch->events.data()));
      EXPECT_GE(event.step, events.empty() ? 0 : events.back().step);
      events.push_back(event);
    }
    EXPECT_EQ(batch->last_sequence, events.empty() ? before : events.back().sequence);
  }
  return events;
}

}  // namespace genphys::testing
