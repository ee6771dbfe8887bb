#include "genphys/hosting/keyframes.h"

#include <algorithm>
#include <atomic>
#include <utility>
#include <variant>

#include "genphys/wire/encode_frame.h"

namespace genphys {
namespace {

template <typename... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};

// No other keyframe of any world has it, so that one of an earlier epoch, or of another world, is not taken for it.
uint64_t NewId() {
  static std::atomic<uint64_t> next = NewEpoch();
  uint64_t id = 0;
  while (id == 0) id = next.fetch_add(1);
  return id;
}

EncodedMessage Stamped(const v1::WorldStamp& stamp, Bytes body) {
  std::string head;
  AppendStamp(stamp, head);
  return {MakeBytes(std::move(head)), std::move(body)};
}

EncodedMessage EncodeFrame(const World& world, const v1::FrameRequest& request, const v1::WorldStamp& stamp,
                           const FrameNames& names, std::vector<uint32_t> rows) {
  const FrameEncoder frame(world, request, names, std::move(rows));
  return Stamped(stamp, MakeBytes(frame.size(), [&](char* to) { frame.Write(to); }));
}

}  // namespace

void Keyframes::FollowStep(const World& world) {
  if (kept_.empty()) return;
  Changed();
  Spread(world);
}

void Keyframes::FollowCommands(const World& world, std::span<const Command> commands) {
  if (kept_.empty() || commands.empty()) return;
  Changed();
  bool any_row = false, other_rows = false;
  for (const Command& command : commands) {
    std::visit(Overloaded{[&](const ApplyForce& force) { touched_.Add(force.id.index()); },
                          [&](const ApplyImpulse& impulse) { touched_.Add(impulse.id.index()); },
                          [&](const SetVelocity& velocity) { touched_.Add(velocity.id.index()); },
                          [&](const SetPose& pose) { touched_.Add(pose.id.index()); },
                          [&](const ApplyForceColumns& forces) {
                            for (const EntityId id : forces.ids) touched_.Add(id.index());
                          },
                          [](const SetMotorColumns&) {}, [&](const CreateEntity&) { other_rows = true; },
                          [&](const DeleteEntity&) { other_rows = true; }, [&](const auto&) { any_row = true; }},
               command);
  }
  if (other_rows) {
    for (Kept& kept : kept_) kept.check_rows = true;
  }
  // What came may stand where something else was.
  if (any_row || other_rows) touched_.AddAll(world.state().rows());
  Spread(world);
}

void Keyframes::Changed() {
  ++changes_;
  touched_.Clear();
  kept_.remove_if([&](const Kept& kept) { return changes_ - kept.used_at > kUnusedChangesMax; });
}

void Keyframes::Spread(const World& world) {
  touched_.Add(world.lately_active());
  for (Kept& kept : kept_) kept.keyframe.MayDiffer(touched_);
}

Keyframes::Kept* Keyframes::Find(uint64_t id, const std::string& wishes, const World& world,
                                 const v1::FrameRequest& request) {
  const auto kept =
      std::find_if(kept_.begin(), kept_.end(), [&](const Kept& each) { return each.keyframe.id() == id; });
  if (id == 0 || kept == kept_.end() || kept->wishes != wishes) return nullptr;
  if (kept->check_rows && !kept->keyframe.HasRowsOf(world.state(), request)) return nullptr;
  kept->check_rows = false;
  kept->used_at = changes_;
  return &*kept;
}

Keyframes::Kept& Keyframes::MakeWhole(const World& world, const v1::FrameRequest& request, const std::string& wishes,
                                      uint64_t step) {
  const auto same = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) {
    return kept.made_at == changes_ && !kept.check_rows && kept.wishes == wishes;
  });
  if (same != kept_.end()) return *same;
  kept_.push_front({wishes, Keyframe(world.state(), request, NewId(), step), 0, changes_, changes_});
  Kept& made = kept_.front();
  made.bytes = made.keyframe.bytes() + wishes.size();
  Forget();
  return made;
}

void Keyframes::Forget() {
  const auto bytes = [&] {
    size_t sum = 0;
    for (const Kept& kept : kept_) sum += kept.bytes;
    return sum;
  };
  while (kept_.size() > 1 && (kept_.size() > kKeyframesMax || bytes() > kBytesMax)) {
    kept_.erase(std::min_element(std::next(kept_.begin()), kept_.end(),
                                 [](const Kept& a, const Kept& b) { return a.used_at < b.used_at; }));
  }
}

Keyframes::Encoded Keyframes::Encode(const World& world, const v1::FrameRequest& request, const v1::WorldStamp& stamp,
                                     uint64_t base) {
  if (!request.deltas()) return {Stamped(stamp, bodies_.Encode(world, request)), 0};
  v1::FrameRequest wanted = request;
  wanted.clear_keyframe_id();
  const std::string wishes = wanted.SerializeAsString();
  if (const Kept* const kept = Find(base, wishes, world, request)) {
    const Keyframe& keyframe = kept->keyframe;
    std::vector<uint32_t> rows = keyframe.Differing(world.state());
    if (static_cast<double>(rows.size()) <= kDifferingMax * static_cast<double>(keyframe.rows())) {
      return {EncodeFrame(world, request, stamp, {keyframe.id(), keyframe.step()}, std::move(rows)), keyframe.id()};
    }
  }
  const Keyframe& made = MakeWhole(world, request, wishes, stamp.step()).keyframe;
  return {EncodeFrame(world, request, stamp, {made.id(), std::nullopt}, {}), made.id()};
}

}  // namespace genphys
