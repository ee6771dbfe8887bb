#include "genphys/hosting/frame_hub.h"

#include <algorithm>
#include <map>
#include <utility>

#include "frame_subscription.h"
#include "kept_state.h"

namespace genphys {

FrameHub::FrameHub(WorkerPool& pool, std::function<void()> call_current)
    : pool_(pool), call_current_(std::move(call_current)) {}

bool FrameHub::HasViewers() const {
  const std::lock_guard lock(mutex_);
  return !layouts_.empty();
}

void FrameHub::Publish(const World& world, const Stamp& stamp, Keyframes& keyframes) {
  Deliver(world, stamp, keyframes, true);
}

void FrameHub::PublishCurrent(const World& world, const Stamp& stamp, Keyframes& keyframes) {
  Deliver(world, stamp, keyframes, false);
}

struct FrameHub::Orders {
  using Viewers = std::vector<std::shared_ptr<FrameSubscription>>;
  struct Frames {
    Layout* layout;
    std::map<uint64_t, Viewers> takers;  // by the keyframe that they have
  };
  std::vector<Frames> frames;
  Viewers keepers;  // of the state
};

FrameHub::Orders FrameHub::TakeOrders(const World& world, const Stamp& stamp, bool is_new) {
  using Need = FrameSubscription::Need;
  Orders orders;
  const std::lock_guard lock(mutex_);
  for (auto layout = layouts_.begin(); layout != layouts_.end();) {
    std::erase_if(layout->viewers, [](const auto& viewer) { return viewer.expired(); });
    if (layout->viewers.empty()) {
      layout = layouts_.erase(layout);
      continue;
    }
    Orders::Frames frames{&*layout, {}};
    const bool is_cheap = layout->frame_bytes <= kWrittenHereMax;
    for (const auto& weak : layout->viewers) {
      const auto viewer = weak.lock();
      if (viewer == nullptr) continue;
      viewer->CheckOnce(world);
      const Need need = is_new                      ? viewer->Offer(stamp.step, is_cheap)
                        : viewer->WaitsForCurrent() ? Need::kFrame
                                                    : Need::kNothing;
      if (need == Need::kFrame) frames.takers[viewer->keyframe_].push_back(viewer);
      if (need == Need::kState) orders.keepers.push_back(viewer);
    }
    if (!frames.takers.empty()) orders.frames.push_back(std::move(frames));
    ++layout;
  }
  return orders;
}

void FrameHub::Deliver(const World& world, const Stamp& stamp, Keyframes& keyframes, bool is_new) {
  Orders orders = TakeOrders(world, stamp, is_new);
  if (orders.frames.empty() && orders.keepers.empty()) return;
  // Layouts stay where they are until the world comes here again, and only it reads and writes what is used of them
  // here.
  v1::WorldStamp encoded_stamp;
  stamp.Encode(&encoded_stamp);
  for (Orders::Frames& order : orders.frames) {
    while (!order.takers.empty()) {
      const auto [base, takers] = *order.takers.begin();
      order.takers.erase(order.takers.begin());
      const Keyframes::Encoded frame = keyframes.Encode(world, *order.layout->request, encoded_stamp, base);
      const bool is_delta = base != 0 && frame.keyframe_id == base;
      const size_t bytes = SizeOf(frame.frame);
      std::vector<std::function<void()>> deliveries;
      {
        const std::lock_guard lock(mutex_);
        for (const auto& viewer : takers) {
          if (is_delta && viewer->keyframe_ != base) {
            // It has come for what was kept for it meanwhile, which was another keyframe.
            order.takers[viewer->keyframe_].push_back(viewer);
          } else if (auto delivery = viewer->Take(frame)) {
            deliveries.push_back(std::move(delivery));
          }
        }
      }
      Send(std::move(deliveries), bytes);
      order.layout->frame_bytes = bytes;
    }
  }
  if (orders.keepers.empty()) return;
  const auto state = std::make_shared<KeptState>(world.state(), encoded_stamp);
  const std::lock_guard lock(mutex_);
  for (const auto& viewer : orders.keepers) {
    if (auto delivery = viewer->Keep(state)) pool_.Post(std::move(delivery));
  }
}

void FrameHub::Send(std::vector<std::function<void()>> deliveries, size_t bytes) {
  // A single small frame is written sooner than another thread wakes to do it.
  const bool here = deliveries.size() == 1 && bytes <= kWrittenHereMax;
  for (std::function<void()>& delivery : deliveries) here ? delivery() : pool_.Post(std::move(delivery));
}

void FrameHub::End(const Status& why) {
  const std::lock_guard lock(mutex_);
  if (end_) return;
  end_ = why;
  for (const Layout& layout : layouts_) {
    for (const auto& weak : layout.viewers) {
      const auto viewer = weak.lock();
      if (viewer == nullptr) continue;
      if (!viewer->end_) viewer->end_ = why;
      viewer->Settle();
    }
  }
}

std::shared_ptr<Subscription> FrameHub::Watch(Bytes request) {
  auto subscription = std::make_shared<FrameSubscription>(shared_from_this());
  pool_.Post([subscription, request = std::move(request)] { subscription->Open(request); });
  return subscription;
}

}  // namespace genphys
